// SPDX-License-Identifier: Apache-2.0
// The config reader: exact messages, merging, origins, variables, --set, and where relative paths start.
#include "config/document.hpp"
#include "binnacle/section.hpp"

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <memory>
#include <string>

#include "catch.hpp"

namespace document_test {

using namespace binnacle;
using internal::config::Document;
namespace fs = std::filesystem;

namespace {

/// A folder with config files; the current folder while it lives, so that messages have short names.
class Folder {
 public:
  Folder() : before_(fs::current_path()) {
    path_ = fs::temp_directory_path() / ("binnacle_document_" + std::to_string(::getpid()));
    fs::create_directories(path_);
    fs::current_path(path_);
    path_ = fs::current_path();
  }
  ~Folder() {
    fs::current_path(before_);
    fs::remove_all(path_);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  void write(const std::string& name, const std::string& text) const {
    if (fs::path(name).has_parent_path()) fs::create_directories(path_ / fs::path(name).parent_path());
    std::ofstream(path_ / name) << text;
  }
  const fs::path& path() const { return path_; }

 private:
  fs::path before_;
  fs::path path_;
};

/// A section of a library beside the kernel whose variants are patches.
class Variants final : public Section {
 public:
  std::vector<std::string> keys() const override { return {"study"}; }
  std::vector<std::string> patches() const override { return {"/study/variants", "/study/dimensions/*"}; }
  std::shared_ptr<const SectionData> read(CompositionDraft&) const override { return nullptr; }
};

LoadOptions with_variants() {
  LoadOptions options;
  options.sections = {std::make_shared<const Variants>()};
  return options;
}

std::string errors_of(const std::string& text, const LoadOptions& options = {}) {
  Diagnostics diagnostics;
  Document::load("a.json", options, diagnostics, text);
  return diagnostics.text();
}

Document parsed(const std::string& text, const LoadOptions& options = {}) {
  Diagnostics diagnostics;
  Document document = Document::load("a.json", options, diagnostics, text);
  INFO(diagnostics.text());
  REQUIRE(diagnostics.empty());
  return document;
}

std::string resolved(const std::string& text, const LoadOptions& options = {}) {
  return parsed(text, options).root().dump();
}

std::string load_errors(const std::string& name, const LoadOptions& options = {}) {
  Diagnostics diagnostics;
  Document::load(name, options, diagnostics);
  return diagnostics.text();
}

Document loaded(const std::string& name, const LoadOptions& options = {}) {
  Diagnostics diagnostics;
  Document document = Document::load(name, options, diagnostics);
  INFO(diagnostics.text());
  REQUIRE(diagnostics.empty());
  return document;
}

/// The text at the pointer as a path.
std::string path_at(const Document& document, const std::string& pointer) {
  return (document.base_dir(pointer) / document.value(pointer)->get<std::string>()).lexically_normal().string();
}

LoadOptions with_sets(std::initializer_list<std::string> sets) { return {{}, sets}; }

}  // namespace

TEST_CASE("the text of the options is read in the file's place", "[document]") {
  LoadOptions options;
  options.text = R"({"binnacle": 1, "title": "not of the file"})";
  const Config config = Config::load("/nowhere/a.json", options);
  CHECK(nlohmann::json::parse(config.text())["title"] == "not of the file");
  CHECK(config.origin("/title").file == "/nowhere/a.json");
}

TEST_CASE("comments, a byte order mark and every kind of value are read", "[document]") {
  CHECK(resolved("\xEF\xBB\xBF{ // c\n \"a\": [1, -2.5e3, true, null, \"x\\u00e9\\ud83d\\ude00\\n\"], /* b "
                 "*/ \"o\": {} }") == "{\"a\":[1,-2500.0,true,null,\"x\u00e9\U0001F600\\n\"],\"o\":{}}");
  CHECK(parsed("{\"n\": 9007199254740993}").root()["n"] == 9007199254740993);
  CHECK(parsed("{\"url\": \"http://x/*y*/\"}").root()["url"] == "http://x/*y*/");
}

TEST_CASE("syntax errors give line, column, what was found and expected", "[document]") {
  CHECK(errors_of("{\n  \"a\" 1\n}") == "a.json:2:7: error[B001]: expected ':' after the key 'a', found '1'");
  CHECK(errors_of("{\"a\": tau}") == "a.json:1:7: error[B001]: expected a value, found 'tau'");
  CHECK(errors_of("{\"a\": 2h}") ==
        "a.json:1:7: error[B001]: bad number '2h'; a number reads like -0.5 or 1e-3, one with a unit needs double "
        "quotes");
  CHECK(errors_of("{\"a\": 01}").find("bad number '01'") != std::string::npos);
  CHECK(errors_of("{'a': 1}") ==
        "a.json:1:2: error[B001]: expected a key in double quotes or '}', found a single quote; texts stand "
        "in double "
        "quotes");
  CHECK(errors_of("{\"a\": \"x\n\"}") == "a.json:1:7: error[B001]: the text is never closed; expected '\"'");
  CHECK(errors_of("{ /* x") == "a.json:1:3: error[B001]: the comment is never closed; expected '*/'");
  CHECK(errors_of("{\n \"a\": {\"b\": 1") ==
        "a.json:2:14: error[B001]: expected ',' or '}' after the value, found the end of the text; '{' was "
        "opened at "
        "line 2, column 7");
  CHECK(errors_of("{} x") == "a.json:1:4: error[B001]: expected the end of the text after the last value, found 'x'");
  CHECK(errors_of("{\"\u00e9\": ?}") == "a.json:1:7: error[B001]: expected a value, found '?'");
  CHECK(errors_of("[]") == "a.json:1:1: error[B006]: a config is an object, found a list");
  CHECK(errors_of("") == "a.json:1:1: error[B001]: expected a value, found the end of the text");
  CHECK(errors_of("{\"a\": \"\xFF\"}") == "a.json:1:7: error[B001]: the text is not UTF-8");
  CHECK(errors_of("{\"a\": " + std::string(300, '[')).find("nested more than 200 deep") != std::string::npos);
}

TEST_CASE("what a text and a number cannot hold is reported with its place", "[document]") {
  const std::string head = "a.json:1:10: error[B001]: bad text: ";
  CHECK(errors_of(R"({"a": "x\q"})") ==
        head + R"(forbidden character after backslash; a backslash itself is written '\\')");
  CHECK(errors_of("{\"a\": \"xy\t\"}") == head + R"(control character U+0009 (HT) must be escaped to \u0009 or \t)");
  CHECK(errors_of(R"({"a": "\u1x"})").find(R"('\u' must be followed by 4 hex digits)") != std::string::npos);
  CHECK(errors_of(R"({"a": "\ud83d"})").find("surrogate U+D800..U+DBFF must be followed by") != std::string::npos);
  CHECK(errors_of(R"({"a": "x\)") == "a.json:1:7: error[B001]: the text is never closed; expected '\"'");
  CHECK(errors_of(R"({"a": 1e999})") == "a.json:1:7: error[B001]: number '1e999' is out of range");
  CHECK(errors_of(R"({"a": 1e-400})") == "a.json:1:7: error[B001]: number '1e-400' is out of range");
  CHECK(parsed(R"({"a": 2.2250738585072011e-308})").root()["a"] == 2.2250738585072011e-308);
}

TEST_CASE("commas too many, commas too few and duplicate keys are reported together", "[document]") {
  CHECK(errors_of("{\n  \"a\": [1, 2,],\n  \"b\": 1\n  \"c\": 2,\n  \"a\": 3,\n}") ==
        "a.json:2:13: error[B001]: trailing comma before ']'; delete it\na.json:3:9: error[B001]: expected ',' or '}' "
        "after the value, found '\"'\na.json:5:3: error[B002] /a: duplicate key 'a'; the first is at line 2, column "
        "3\na.json:5:9: error[B001]: trailing comma before '}'; delete it");
}

TEST_CASE("places of keys and values", "[document]") {
  const Document document = parsed("{\n  \"a/b\": { \"c\":\n    [10, \"x\"] } }");
  CHECK(document.key_origin("/a~1b") == Origin{"a.json", 2, 3});
  CHECK(document.origin("/a~1b") == Origin{"a.json", 2, 10});
  CHECK(document.key_origin("/a~1b/c") == Origin{"a.json", 2, 12});
  CHECK(document.origin("/a~1b/c") == Origin{"a.json", 3, 5});
  CHECK(document.origin("/a~1b/c/1") == Origin{"a.json", 3, 10});
  CHECK(document.origin("/a~1b/none/deeper") == Origin{"a.json", 2, 10});
  CHECK(document.origin("/none") == Origin{"a.json", 1, 1});
  CHECK(document.origin("") == Origin{"a.json", 1, 1});
}

TEST_CASE("extends merges as RFC 7386, the base's keys first", "[document]") {
  const Folder folder;
  folder.write("base.json", "{\"x\": {\"p\": 1, \"q\": 2, \"r\": [1, 2]}, \"y\": 1, \"z\": 5}");
  folder.write("a.json",
               "{\n  \"extends\": \"base.json\",\n  \"n\": 0,\n"
               "  \"x\": {\"q\": null, \"p\": 7, \"r\": [3]},\n  \"y\": {\"k\": 1, \"gone\": null}\n}");
  const Document document = loaded("a.json");
  CHECK(document.root().dump() == "{\"x\":{\"p\":7,\"r\":[3]},\"y\":{\"k\":1},\"z\":5,\"n\":0}");
  CHECK(document.origin("/z") == Origin{"base.json", 1, 51});
  CHECK(document.origin("/x/p") == Origin{"a.json", 4, 25});
  CHECK(document.key_origin("/x/p") == Origin{"a.json", 4, 20});
  CHECK(document.origin("/x") == Origin{"a.json", 4, 8});
}

TEST_CASE("a list of bases is merged from left to right, and bases have bases", "[document]") {
  const Folder folder;
  folder.write("common/root.json", "{\"a\": 1, \"b\": 1, \"c\": 1, \"path\": \"d.csv\"}");
  folder.write("common/one.json", "{\"extends\": \"root.json\", \"b\": 2}");
  folder.write("two.json", "{\"c\": 3, \"a\": null}");
  folder.write("sub/main.json", "{\"extends\": [\"../common/one.json\", \"../two.json\"], \"e\": 4}");
  const Document document = loaded("sub/main.json");
  CHECK(document.root().dump() == "{\"b\":2,\"c\":3,\"path\":\"d.csv\",\"e\":4}");
  CHECK(document.origin("/path").file == "common/root.json");
  CHECK(document.base_dir("/path") == folder.path() / "common");
  CHECK(path_at(document, "/path") == (folder.path() / "common/d.csv").string());
  CHECK(document.base_dir("/e") == folder.path() / "sub");
}

TEST_CASE("a nested object extends a part of another file", "[document]") {
  const Folder folder;
  folder.write("base.json", "{\"filters\": {\"slow\": {\"tau\": 9, \"m\": {\"k\": 1}}}}");
  folder.write("library.json",
               "{\"extends\": \"base.json\", \"filters\": {\"fast\": {\"extends\": \"#/filters/slow\", \"tau\": 1}}}");
  folder.write("a.json",
               "{\"filters\": {\"ins\": {\"m\": {\"k\": null, \"l\": 2}, \"extends\": "
               "\"library.json#/filters/fast\"},\n"
               "  \"again\": {\"extends\": \"#/filters/ins\", \"tau\": 3}}}");
  const Document document = loaded("a.json");
  CHECK(document.root().dump() ==
        "{\"filters\":{\"ins\":{\"tau\":1,\"m\":{\"l\":2}},\"again\":{\"tau\":3,\"m\":{\"l\":2}}}}");
  CHECK(document.origin("/filters/ins/tau").file == "library.json");
  CHECK(document.origin("/filters/again/tau") == Origin{"a.json", 2, 48});
}

TEST_CASE("an object in a list may extend, and a list hides the base's", "[document]") {
  const Folder folder;
  folder.write("base.json", "{\"list\": [{\"a\": 1}, {\"b\": 2}], \"t\": {\"k\": 1}}");
  folder.write("a.json",
               "{\"extends\": \"base.json\", \"list\": [{\"extends\": \"base.json#/t\"}],\n"
               " \"copy\": {\"extends\": \"#/list/0\", \"n\": 1}}");
  CHECK(loaded("a.json").root().dump() == "{\"list\":[{\"k\":1}],\"t\":{\"k\":1},\"copy\":{\"k\":1,\"n\":1}}");
}

TEST_CASE("patches are merged over the config, in order, before --set and after what --set puts into them",
          "[document]") {
  const std::string text = R"({"a": 1, "b": {"x": 1, "y": 2}, "study": {"variants": {"v": {"b": {"y": null, "z": 3}}},)"
                           R"( "dimensions": {"d": {"e": {"a": 5, "b": {"z": 4}}}}}})";
  const auto run_part = [&](const LoadOptions& options) {
    auto root = parsed(text, options).root();
    root.erase("study");
    return root.dump();
  };
  CHECK(run_part(with_variants()) == R"({"a":1,"b":{"x":1,"y":2}})");
  LoadOptions options = with_variants();
  options.patches = {"/study/variants/v", "/study/dimensions/d/e"};
  CHECK(run_part(options) == R"({"a":5,"b":{"x":1,"z":4}})");
  options.sets = {"/a=7", "/study/dimensions/d/e/b/z=8", "/study/variants/v/c=9"};
  CHECK(run_part(options) == R"({"a":7,"b":{"x":1,"z":8},"c":9})");
  CHECK(parsed(text, with_variants()).hash({"a", "b"}) ==
        parsed(R"({"a": 1, "b": {"x": 1, "y": 2}})").hash({"a", "b"}));
  options.patches = {"/study/variants/w"};
  options.sets = {};
  CHECK(errors_of(text, options) ==
        "a.json:1:1: error[B029] /study/variants/w: there is no object here to be merged over the config");
}

TEST_CASE("variants of a study keep their nulls", "[document]") {
  CHECK(resolved("{\"x\": null, \"study\": {\"runs\": null, \"variants\": {\"plain\": {\"a\": {\"noise\": "
                 "null}}}}}",
                 with_variants()) == "{\"study\":{\"variants\":{\"plain\":{\"a\":{\"noise\":null}}}}}");
}

TEST_CASE("a missing file is reported where it was named", "[document]") {
  const Folder folder;
  CHECK(load_errors("none.json") == "none.json: error[B003]: cannot read 'none.json': No such file or directory");
  folder.write("sub/a.json", "{\n  \"extends\": [\"none.json\", \"..\"]\n}");
  CHECK(load_errors("sub/a.json") ==
        "sub/a.json:2:15: error[B003] /extends: cannot read 'sub/none.json': No such file or directory\n"
        "sub/a.json:2:28: error[B003] /extends: cannot read '.': it is a folder");
}

TEST_CASE("a cycle of extends is reported as its chain", "[document]") {
  const Folder folder;
  folder.write("a.json", "{\"extends\": \"b.json\"}");
  folder.write("b.json", "{\"extends\": \"c.json\"}");
  folder.write("c.json", "{\n  \"extends\": \"b.json\"}");
  CHECK(load_errors("a.json") ==
        "b.json:1:13: error[B004] /extends: extends forms a cycle: b.json -> c.json -> b.json");
  CHECK(errors_of("{\"f\": {\"extends\": \"#/f\"}}").find("extends forms a cycle: ") != std::string::npos);
  folder.write("d.json", "{\"f\": {\"x\": {\"extends\": \"#/f\"}}}");
  CHECK(load_errors("d.json") ==
        "d.json:1:25: error[B004] /f/x/extends: extends forms a cycle: d.json#/f/x -> d.json#/f");
  folder.write("e.json", "{\"extends\": \"#/q\", \"q\": {}}");
  CHECK(load_errors("e.json") == "e.json:1:13: error[B004] /extends: extends forms a cycle: e.json -> e.json#/q");
}

TEST_CASE("extends must name an object that is there", "[document]") {
  const Folder folder;
  folder.write("base.json", "{\"filters\": {\"strapdown\": {}, \"n\": 3}}");
  const auto error = [&](const std::string& extends) {
    folder.write("a.json", "{\"x\": {\"extends\": " + extends + "}}");
    return load_errors("a.json");
  };
  const std::string head = "a.json:1:19: error[B004] /x/extends: ";
  CHECK(error("\"base.json#/filters/strapdwon\"") ==
        head + "there is no 'base.json#/filters/strapdwon'; did you mean '#/filters/strapdown'?");
  CHECK(error("\"base.json#/filters/n\"") == head + "'base.json#/filters/n' is a number, not an object");
  CHECK(error("5") == head + "expected a file name or a list of file names, found a number");
  CHECK(error("\"base.json#filters\"") ==
        head + "'base.json#filters' names no file; what follows '#' is a JSON pointer, '#/filters/ins' say");
  CHECK(error("\"\"") == head + "'' names no file");
}

TEST_CASE("a config that doubles itself does not fill the memory", "[document]") {
  const Folder folder;
  std::string text = "{\"l0\": {\"v\": 1}";
  for (int i = 1; i < 60; ++i) {
    const std::string below = "{\"extends\": \"#/l" + std::to_string(i - 1) + "\"}";
    text += ",\n\"l" + std::to_string(i) + "\": {\"a\": " + below + ", \"b\": " + below + "}";
  }
  folder.write("a.json", text + "}");
  CHECK(load_errors("a.json").find("error[B033]") != std::string::npos);
}

TEST_CASE("variables are filled into texts, not into keys", "[document]") {
  CHECK(resolved("{\"vars\": {\"d\": \"x\", \"n\": 0.5, \"e\": \"${d}/y\"}, \"${d}\": [\"${e}/z\", \"${n} s\", "
                 "\"${n}\", \"$${d}\", \"$5\"]}") ==
        "{\"vars\":{\"d\":\"x\",\"n\":0.5,\"e\":\"x/y\"},\"${d}\":[\"x/y/z\",\"0.5 s\",0.5,\"${d}\",\"$5\"]}");
  CHECK(resolved("{\"vars\": {\"n\": 1, \"t\": \"a\"}, \"p\": \"${n}\", \"q\": \"${t}\"}",
                 {{{"n", "2"}, {"t", "3"}}, {}}) == "{\"vars\":{\"n\":2,\"t\":\"3\"},\"p\":2,\"q\":\"3\"}");
  CHECK(resolved("{\"p\": \"${run}.csv\"}", {{{"run", "${x}"}}, {}}) ==
        "{\"p\":\"${x}.csv\",\"vars\":{\"run\":\"${x}\"}}");
}

TEST_CASE("mistakes with variables", "[document]") {
  CHECK(errors_of("{\"vars\": {\"drive\": \"x\"},\n \"p\": \"${drvie}/imu\", \"q\": \"${other}\", \"r\": \"${\"}") ==
        "a.json:2:7: error[B005] /p: unknown variable 'drvie'; did you mean 'drive'?\n"
        "a.json:2:28: error[B005] /q: unknown variable 'other'; define it under /vars or give --var "
        "other=VALUE\n"
        "a.json:2:45: error[B005] /r: '${': expected '${name}'; a literal '${' is written '$${'");
  CHECK(errors_of("{\"vars\": {\"drive\": \"x\"}}", {{{"drives", "y"}, {"dr=", ""}}, {}}) ==
        "--var: error[B029]: '--var dr=' is not name=value\n--var: error[B029]: the config has no variable "
        "'drives'; did you mean 'drive'?");
  CHECK(errors_of("{\"vars\": {\"a\": \"${b}\", \"b\": \"${a}\"}}") ==
        "a.json:1:16: error[B005] /vars/a: variables form a cycle: b -> a -> b");  // once
  CHECK(errors_of("{\"vars\": {\"a\": [1]}}") ==
        "a.json:1:16: error[B006] /vars/a: expected a text or a number, found a list");
}

TEST_CASE("a path starts where its first component was named", "[document]") {
  const Folder folder;
  folder.write("common/base.json",
               "{\"vars\": {\"drives\": \"../data\"}, \"p\": \"local.csv\", \"q\": \"/abs/../x.csv\"}");
  folder.write("configs/a.json",
               "{\"extends\": \"../common/base.json\", \"imu\": \"${drives}/imu.csv\", \"g\": \"gnss/${drives}\"}");
  const fs::path top = folder.path();
  const Document plain = loaded("configs/a.json");
  CHECK(path_at(plain, "/imu") == (top / "data/imu.csv").string());
  CHECK(plain.origin("/imu").file == "configs/a.json");
  CHECK(path_at(plain, "/p") == (top / "common/local.csv").string());
  CHECK(path_at(plain, "/q") == "/x.csv");
  CHECK(plain.base_dir("/g") == top / "configs");
  const Document given = loaded("configs/a.json", {{{"drives", "here"}}, {"/p=set.csv", "/r=${drives}/r.csv"}});
  CHECK(path_at(given, "/imu") == (top / "here/imu.csv").string());
  CHECK(path_at(given, "/p") == (top / "set.csv").string());
  CHECK(path_at(given, "/r") == (top / "here/r.csv").string());
}

TEST_CASE("option --set reads JSON, else a text, and knows its origin", "[document]") {
  const std::string text = "{\"a\": {\"b\": 1, \"c/d\": 2}, \"l\": [1, 2]}";
  CHECK(resolved(text, with_sets({"/a/b=2.5", "/a/c~1d=2 h", "/l/-={\"k\": 1, \"n\": null}", "/l/0=true",
                                  "/new/x/y=\"3\"", "/e=a=b"})) ==
        "{\"a\":{\"b\":2.5,\"c/d\":\"2 "
        "h\"},\"l\":[true,2,{\"k\":1}],\"new\":{\"x\":{\"y\":\"3\"}},\"e\":\"a=b\"}");
  CHECK(resolved(text, with_sets({"/a/b=null", "/l/0=null"})) == "{\"a\":{\"c/d\":2},\"l\":[2]}");
  const Document document = parsed(text, with_sets({"/a/b=2", "/a/new=1"}));
  CHECK(document.origin("/a/b") == Origin{"--set", 0, 0});
  CHECK(document.key_origin("/a/b") == Origin{"--set", 0, 0});
  CHECK(document.origin("/a/new") == Origin{"--set", 0, 0});
  CHECK(document.origin("/a/c~1d") == Origin{"a.json", 1, 23});
  CHECK(resolved("{\"vars\": {\"v\": \"x\"}}", with_sets({"/p=${v}y"})) == "{\"vars\":{\"v\":\"x\"},\"p\":\"xy\"}");
}

TEST_CASE("mistakes with --set", "[document]") {
  const std::string text = "{\"a\": {\"beta\": 1}, \"l\": [1, 2]}";
  CHECK(errors_of(text, with_sets({"a/beta=1", "/a", "/a/beta/c=1", "/l/2=1", "/a/bta=null", "/a/x={1",
                                   "/extends=\"b\"", "/~2=1"})) ==
        "--set: error[B029]: 'a/beta' is not a JSON pointer; did you mean '/a/beta'?\n--set: error[B029] /a: '/a' is "
        "not of the form /pointer=value\n--set: error[B029] /a/beta/c: '/a/beta' is a number, not an object or "
        "list\n--set: error[B029] /l/2: '/l' is a list of 2; '2' is not one of its indices (which start at 0; '-' "
        "appends)\n--set: error[B029] /a/bta: there is nothing to delete; did you mean '/a/beta'?\n--set: error[B029] "
        "/a/x: '{1' begins like JSON but is not\n--set: error[B029] /extends: extends cannot be set; it is resolved "
        "before --set\n--set: error[B029] /~2: a '~' in a JSON pointer is written '~0', a '/' inside a key '~1'");
}

TEST_CASE("the hash follows the resolved document", "[document]") {
  const std::uint64_t plain = parsed("{\"a\": 1, \"b\": 2}").hash();
  CHECK(plain == parsed("{ // the same\n  \"a\": 1,\n  \"b\": 2 }").hash());
  CHECK(plain != parsed("{\"a\": 1, \"b\": 3}").hash());
  CHECK(plain != parsed("{\"b\": 2, \"a\": 1}").hash());
  CHECK(parsed("{}").hash() == 0x08f44b07b5901a25U);
}

}  // namespace document_test
