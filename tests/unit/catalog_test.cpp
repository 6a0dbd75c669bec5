// SPDX-License-Identifier: Apache-2.0
// The loader and the catalog, on plugins that are good, broken, and hostile; BINNACLE_LOADER_TEST_PLUGINS is their place.
#include "binnacle/catalog.hpp"
#include "document/document.hpp"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "catch.hpp"
#include "loader_work.hpp"
#include "plugin/library.hpp"

namespace catalog_test {

using namespace binnacle;
using namespace loader_work;

namespace {

/// Parameters of the thrower.
ParameterValue what(const std::string& text) {
  ParameterValue object;
  object.type = ParameterValue::Type::object;
  ParameterValue word;
  word.type = ParameterValue::Type::text;
  word.text = text;
  object.members.emplace_back("what", word);
  return object;
}

Binding binding(const ParameterValue& parameters) { return Binding({"it", Parameters(parameters)}); }

}  // namespace

TEST_CASE("a good plugin brings its types", "[catalog]") {
  Catalog catalog;
  Diagnostics diagnostics;
  catalog.load(plugin_at("good"), diagnostics);
  CHECK(lines(diagnostics) == Lines{});
  std::vector<std::string> names;
  for (const ComponentType* type : catalog.types()) names.push_back(role_name(type->role) + (" " + type->full_name()));
  CHECK(names == Lines{"state block good/still", "process model good/rest", "source good/thrower"});
  REQUIRE(catalog.plugins().size() == 1);
  CHECK(catalog.plugins()[0].version == "1.2.3");
  CHECK(catalog.find(Role::state_block, "still") == catalog.find(Role::state_block, "good/still"));
  CHECK(catalog.find(Role::state_block, "still") != nullptr);
  CHECK(catalog.find(Role::source, "still") == nullptr);

  catalog.load(plugin_at("good"), diagnostics);
  catalog.load(folder / "." / "good.so", diagnostics);
  CHECK(lines(diagnostics) == Lines{});
  CHECK(catalog.types().size() == 3);
}

TEST_CASE("names that lead nowhere are reported", "[catalog]") {
  Catalog catalog;
  Diagnostics none;
  catalog.load(plugin_at("good"), none);
  const auto message = [&](Role role, const std::string& name) {
    Diagnostics diagnostics;
    CHECK(catalog.find(role, name, {"c.json", 3, 5}, "/x/type", diagnostics) == nullptr);
    return diagnostics.text();
  };
  CHECK(message(Role::state_block, "stil") ==
        "c.json:3:5: error[B011] /x/type: unknown state block 'stil'; did you mean 'still'?");
  CHECK(message(Role::state_block, "god/still") ==
        "c.json:3:5: error[B011] /x/type: unknown state block 'god/still'; did you mean 'good/still'?");
  CHECK(message(Role::measurement_model, "still") ==
        "c.json:3:5: error[B011] /x/type: 'still' is a state block, not a measurement model");
  CHECK(message(Role::sink, "recorder") ==
        "c.json:3:5: error[B011] /x/type: unknown sink 'recorder'; none of the loaded plugins has it: good");
  CHECK(message(Role::state_block, "old_home/still") ==
        "c.json:3:5: error[B011] /x/type: 'old_home/still' is now called 'good/still'");
  CHECK(message(Role::measurement_model, "old_home/still") ==
        "c.json:3:5: error[B011] /x/type: unknown measurement model 'old_home/still'; none of the loaded plugins has "
        "it: good");
  CHECK(Catalog().find(Role::sink, "x", {}, "", none) == nullptr);
  CHECK(none.text() == "error[B011]: unknown sink 'x'; no plugin is loaded");

  Diagnostics loading;
  catalog.load(plugin_at("second"), loading);
  CHECK(lines(loading) == Lines{});
  CHECK(catalog.find(Role::state_block, "still") == nullptr);
  CHECK(catalog.find(Role::state_block, "second/still")->plugin == "second");
  CHECK(message(Role::state_block, "still") ==
        "c.json:3:5: error[B022] /x/type: 'still' is ambiguous; write 'good/still' or 'second/still'");
}

TEST_CASE("what is no plugin is refused before any of it runs", "[catalog]") {
  CHECK(load("no_guard") ==
        Lines{"no_guard.so: error[B041]: not a plugin for this program: it exports no binnacle_guard_v1"});
  CHECK(load("next_version") ==
        Lines{"next_version.so: error[B041]: not a plugin for this program: it is one for another major version "
              "(exports binnacle_guard_v2, not binnacle_guard_v1)"});
  CHECK(load("no_register") ==
        Lines{"no_register.so: error[B041]: not a plugin for this program: it exports no binnacle_register_v1"});
  CHECK(load("absent") == Lines{"absent.so: error[B040]: the plugin cannot be opened: No such file or directory"});
}

TEST_CASE("each field of a foreign guard is reported, and no code of it runs", "[catalog]") {
  ::unsetenv("BINNACLE_TEST_CODE_RAN");
  const auto& host = abi::guard_of_host();
  const std::string cxx11 = std::to_string(host.standard_library_abi & 1);
  const std::string other = std::to_string(1 - static_cast<int>(host.standard_library_abi & 1));
  const Lines found = load("wrong_guard");
  for (const std::string& line : found) UNSCOPED_INFO(line);
  REQUIRE(found.size() == 11);
  CHECK(found[0] == "wrong_guard.so: error[B042]: ABI of the standard library: host _GLIBCXX_USE_CXX11_ABI=" + cxx11 +
                        ", plugin _GLIBCXX_USE_CXX11_ABI=" + other + "; rebuild the plugin with the host's setting");
  CHECK(found[1] ==
        "wrong_guard.so: error[B042]: debug containers: host off, plugin _GLIBCXX_DEBUG; rebuild the "
        "plugin without _GLIBCXX_DEBUG");
  CHECK(found[2].find("wrong_guard.so: error[B042]: sanitizers: host ") == 0);
  if (host.sanitizers == 0) {
    CHECK(found[2] ==
          "wrong_guard.so: error[B042]: sanitizers: host none, plugin address; rebuild the plugin "
          "without -fsanitize");
  }
  CHECK(found[3] ==
        "wrong_guard.so: error[B042]: std::string: host size 32, alignment 8, plugin size 8, alignment 8; "
        "rebuild the plugin with this version's headers and compiler settings");
  CHECK(found[4].find("wrong_guard.so: error[B042]: ParameterSpec: host size ") == 0);
  CHECK(found[5].find(
            "wrong_guard.so: error[B042]: instruction sets: host this processor lacks bit 63, plugin bit 63") == 0);
  CHECK(found[6].find("wrong_guard.so: error[B042]: header hash: host 0x") == 0);
  CHECK(found[7].find("wrong_guard.so: warning[B043]: container assertions: ") == 0);
  CHECK(found[8].find("wrong_guard.so: warning[B043]: Eigen version: host 3.") == 0);
  CHECK(found[9].find("wrong_guard.so: warning[B043]: EIGEN_MAX_ALIGN_BYTES: host ") == 0);
  CHECK(found[10].find("wrong_guard.so: warning[B043]: compiler: host ") == 0);
  CHECK(::getenv("BINNACLE_TEST_CODE_RAN") == nullptr);
}

TEST_CASE("a harmless difference is a warning and the plugin loaded", "[catalog]") {
  Catalog catalog;
  Diagnostics diagnostics;
  catalog.load(plugin_at("only_warned"), diagnostics);
  REQUIRE(lines(diagnostics).size() == 1);
  CHECK(lines(diagnostics)[0].find("only_warned.so: warning[B043]: Eigen version: host 3.") == 0);
  CHECK(catalog.types().size() == 1);
}

TEST_CASE("what goes wrong in a plugin's registration is reported", "[catalog]") {
  CHECK(load("throws_in_register") == Lines{"throws_in_register.so: error[B045]: plugin 'throws_in_register': "
                                            "binnacle_register_v1 threw: out of ideas"});
  CHECK(load("twice") == Lines{"twice.so: error[B046]: plugin 'twice' registers 'still' twice"});
  CHECK(load("bad_spec") ==
        Lines{"bad_spec.so: error[B045]: plugin 'bad_spec', component 'contradiction': parameter 'angle': the unit "
              "'deg' is not SI"});
  const Lines unresolved = load("unresolved");
  REQUIRE(unresolved.size() == 1);
  CHECK(unresolved[0].find("unresolved.so: error[B045]: the plugin cannot be loaded: ") == 0);
  CHECK(unresolved[0].find("undefined symbol: binnacle_test_nobody_has_this") != std::string::npos);
}

TEST_CASE("files that are damaged, foreign, or open to everybody are refused", "[catalog]") {
  const Scratch scratch;
  const auto message = [&](const std::string& name) {
    Catalog catalog;
    Diagnostics diagnostics;
    catalog.load(scratch.path / name, diagnostics);
    CHECK(catalog.types().empty());
    std::string text = diagnostics.text();
    text.erase(0, scratch.path.string().size() + 1);
    return text;
  };
  std::ofstream(scratch.path / "text.so") << std::string(200, 'x');
  CHECK(message("text.so") ==
        "text.so: error[B041]: not a plugin for this program: it is not a shared library (not ELF)");
  std::ofstream(scratch.path / "empty.so");
  CHECK(message("empty.so") == "empty.so: error[B041]: not a plugin for this program: it cannot be read, or is empty");
  fs::create_directory(scratch.path / "folder.so");
  CHECK(message("folder.so") == "folder.so: error[B040]: the plugin is not a file");

  fs::copy_file(plugin_at("good"), scratch.path / "open.so");
  fs::permissions(scratch.path / "open.so", fs::perms::others_write, fs::perm_options::add);
  CHECK(message("open.so") ==
        "open.so: error[B044]: the plugin file is world-writable, so it is not loaded; chmod o-w it");

  std::ifstream whole(plugin_at("good"), std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(whole), {}};
  for (const std::size_t part : {std::size_t{100}, bytes.size() / 2, bytes.size() - 1}) {
    std::ofstream(scratch.path / "cut.so", std::ios::binary | std::ios::trunc) << bytes.substr(0, part);
    CHECK(message("cut.so") == "cut.so: error[B041]: not a plugin for this program: it is damaged or truncated");
  }
  // Whatever byte of its head is wrong: an error or a plugin, never a crash. Not loaded, so inspected only.
  std::string machine = bytes;
  machine[18] = 0x28;  // e_machine: ARM
  machine[19] = 0;
  std::ofstream(scratch.path / "aarch64.so", std::ios::binary) << machine;
  CHECK(message("aarch64.so") ==
        "aarch64.so: error[B041]: not a plugin for this program: it is built for another machine");
}

TEST_CASE("a second copy of a plugin is an error that names the first", "[catalog]") {
  const Scratch scratch;
  fs::copy_file(plugin_at("good"), scratch.path / "copy.so");
  Catalog catalog;
  Diagnostics diagnostics;
  catalog.load(plugin_at("good"), diagnostics);
  catalog.load(scratch.path / "copy.so", diagnostics);
  CHECK(diagnostics.text() == (scratch.path / "copy.so").string() +
                                  ": error[B046]: plugin 'good' is loaded already, from " + plugin_at("good").string());
  CHECK(catalog.types().size() == 3);
}

TEST_CASE("a stripped plugin is found as well", "[catalog]") {
  const Scratch scratch;
  const std::string file = (scratch.path / "stripped.so").string();
  if (std::system(("strip -o " + file + " " + plugin_at("good").string() + " 2>/dev/null").c_str()) != 0) return;
  fs::permissions(file, fs::perms::others_write, fs::perm_options::remove);
  Catalog catalog;
  Diagnostics diagnostics;
  catalog.load(file, diagnostics);
  CHECK(diagnostics.text().empty());
  CHECK(catalog.types().size() == 3);
}

TEST_CASE("the search path: files and folders of the config, then the environment", "[catalog]") {
  const Scratch scratch;
  fs::copy_file(plugin_at("good"), scratch.path / "good.so");
  std::ofstream(scratch.path / "README") << "no plugin";
  const Variable path("BINNACLE_PLUGIN_PATH", scratch.path.string() + "::/nowhere/at/all");
  const Variable allowed("BINNACLE_ALLOW_PLUGINS", "1");
  Catalog catalog;
  Diagnostics diagnostics;
  catalog.load_search_path({{plugin_at("second"), {"c.json", 2, 14}, "/plugins/0"},
                            {"/missing/x.so", {"c.json", 2, 30}, "/plugins/1"}},
                           diagnostics);
  REQUIRE(diagnostics.items().size() >= 2);
  CHECK(to_string(diagnostics.items()[0]) ==
        "c.json:2:30: error[B040] /plugins/1: there is no plugin file or folder '/missing/x.so'");
  CHECK(to_string(diagnostics.items()[1]) ==
        "warning[B040]: BINNACLE_PLUGIN_PATH: there is no folder '/nowhere/at/all'");
  CHECK(catalog.find(Role::state_block, "good/still") != nullptr);
  CHECK(catalog.find(Role::state_block, "second/still") != nullptr);
}

TEST_CASE("folders that the program adds are searched in place of what lies beside it, a missing one in silence",
          "[catalog]") {
  const Scratch scratch;
  fs::copy_file(plugin_at("good"), scratch.path / "good.so");
  Catalog catalog;
  Diagnostics diagnostics;
  catalog.load_search_path({}, diagnostics, {scratch.path, "/nowhere/at/all"});
  CHECK(catalog.plugins().size() == 1);
  CHECK(catalog.find(Role::state_block, "good/still") != nullptr);
  for (const auto& item : diagnostics.items()) CHECK(item.message.find("/nowhere") == std::string::npos);
}

TEST_CASE("a plugin of the program brings types of run-time specs, and lives with them", "[catalog]") {
  std::weak_ptr<const LinkedPlugin> watched;
  ComponentType type;
  {
    Catalog catalog;
    Diagnostics diagnostics;
    auto plugin = linked("mine", {"one", "two"});
    watched = plugin;
    catalog.add(std::move(plugin), diagnostics);
    CHECK(diagnostics.empty());
    REQUIRE(catalog.plugins().size() == 1);
    CHECK(catalog.plugins()[0].file.empty());
    REQUIRE(catalog.find(Role::source, "mine/one") != nullptr);
    type = *catalog.find(Role::source, "two");
  }
  CHECK_FALSE(watched.expired());
  CHECK(type.spec.type == "two");
  type = {};
  CHECK(watched.expired());
}

TEST_CASE("what is wrong with a plugin of the program is refused like that of a file", "[catalog]") {
  const auto refusal = [](std::shared_ptr<const LinkedPlugin> plugin) {
    Catalog catalog;
    Diagnostics diagnostics;
    catalog.add(linked("taken", {"x"}), diagnostics);
    catalog.add(std::move(plugin), diagnostics);
    CHECK(catalog.types().size() == 1);
    return diagnostics.text();
  };
  CHECK(refusal(linked("Mine", {"x"})) == "error[B045]: the plugin's name 'Mine' is not in snake_case");
  CHECK(refusal(linked("taken", {"y"})) == "error[B046]: plugin 'taken' is loaded already, from the program itself");
  CHECK(refusal(linked("mine", {"x", "x"})) == "error[B046]: plugin 'mine' registers 'x' twice");
  CHECK(refusal(std::make_shared<LinkedPlugin>(
            LinkedPlugin{"mine", "3", [](Registry&) { throw std::runtime_error("no types today"); }})) ==
        "error[B045]: plugin 'mine': add_types threw: no types today");
}

TEST_CASE("a stale library in a searched folder is a warning, until a type is wanted that it may have", "[catalog]") {
  const Scratch scratch;
  const Variable allowed("BINNACLE_ALLOW_PLUGINS", "1");
  fs::copy_file(plugin_at("good"), scratch.path / "good.so");
  fs::copy_file(plugin_at("newer"), scratch.path / "newer.so");
  const std::string why = "API minor: host " + std::to_string(abi::api_minor) + ", plugin " +
                          std::to_string(abi::api_minor + 1) +
                          "; update this program, or rebuild the plugin with this version's headers";
  const std::string file = (scratch.path / "newer.so").string();
  const auto find = [&](const std::string& name) {
    Catalog catalog;
    Diagnostics loading, finding;
    catalog.load_search_path({{scratch.path, {"c.json", 2, 14}, "/plugins/0"}}, loading);
    CHECK_FALSE(loading.has_errors());
    REQUIRE(loading.items().size() == 1);
    CHECK(to_string(loading.items()[0]) == file + ": warning[B047]: not loaded: " + why);
    catalog.find(Role::state_block, name, {"c.json", 3, 5}, "/x/type", finding);
    return finding.text();
  };
  CHECK(find("still") == "");
  CHECK(find("modern") == "c.json:3:5: error[B047] /x/type: unknown state block 'modern'; '" + file +
                              "' may contain it, but is not loaded: " + why);
  CHECK(find("newer/modern") == "c.json:3:5: error[B047] /x/type: unknown state block 'newer/modern'; '" + file +
                                    "' may contain it, but is not loaded: " + why);
  CHECK(find("good/stil") ==
        "c.json:3:5: error[B011] /x/type: unknown state block 'good/stil'; did you mean 'good/still'?");

  Catalog named;
  Diagnostics diagnostics;
  named.load_search_path({{file, {"c.json", 2, 14}, "/plugins/0"}}, diagnostics);
  CHECK(diagnostics.text() == file + ": error[B042]: " + why);
}

TEST_CASE("what a constructor throws is contained, and names plugin, component, call", "[catalog]") {
  Catalog catalog;
  Diagnostics diagnostics;
  catalog.load(plugin_at("good"), diagnostics);
  const ComponentType& type = *catalog.find(Role::source, "thrower");
  const auto thrown = [&](const std::string& text) {
    const ParameterValue parameters = what(text);
    try {
      type.create<Source>(binding(parameters));
    } catch (const ComponentError& error) {
      return error;
    }
    return ComponentError("nothing was thrown");
  };
  CHECK(std::string(thrown("component_error").what()) == "too still");
  CHECK(thrown("component_error").pointer() == "/what");
  CHECK(thrown("data_error").file() == "drive.csv");
  CHECK(thrown("data_error").line() == 12);
  CHECK(thrown("data_error").code() == "B062");
  CHECK(std::string(thrown("own_error").what()) ==
        "plugin 'good', component 'thrower': its constructor threw: lost my marbles");
  CHECK(std::string(thrown("int").what()) ==
        "plugin 'good', component 'thrower': its constructor threw: something that is not a std::exception");
  CHECK(std::string(thrown("nothing").what()) == "nothing was thrown");
  const ParameterValue nothing = what("nothing");
  CHECK_THROWS_AS(type.create<Sink>(binding(nothing)), std::logic_error);
}

TEST_CASE("objects and errors outlive the catalog, and the library stays with them", "[catalog]") {
  std::shared_ptr<StateBlock> block;
  std::shared_ptr<Source> source;
  ComponentType copy;
  std::exception_ptr error;
  {
    Catalog catalog;
    Diagnostics diagnostics;
    catalog.load(plugin_at("good"), diagnostics);
    const ParameterValue empty;
    block = catalog.find(Role::state_block, "still")->create<StateBlock>(binding(empty));
    const ParameterValue nothing = what("nothing");
    copy = *catalog.find(Role::source, "thrower");
    source = copy.create<Source>(binding(nothing));
    const ParameterValue bad = what("component_error");
    try {
      copy.create<Source>(binding(bad));
    } catch (...) {
      error = std::current_exception();
    }
  }
  double x = 1;
  const double delta = 2;
  block->plus({&x, 1}, {&delta, 1}, {&x, 1});
  CHECK(x == 3);
  CHECK(block->declaration().kind == "vector:1:m");
  struct Silent final : Reporter {
    void warn(const std::string&, const std::string&, int, const std::string&) override {}
  } silent;
  try {
    copy.guarded("open()", [&] { source->open(silent); });
    FAIL("open() did not throw");
  } catch (const ComponentError& caught) {
    CHECK(std::string(caught.what()) == "plugin 'good', component 'thrower': open() threw: cannot open");
  }
  block.reset();
  source.reset();
  copy = ComponentType();
  // Nothing holds the library now; the error was made by the host and can still be read.
  try {
    std::rethrow_exception(error);
  } catch (const ComponentError& caught) {
    CHECK(std::string(caught.what()) == "too still");
  }
}

TEST_CASE("a type describes itself", "[catalog]") {
  Catalog catalog;
  Diagnostics diagnostics;
  catalog.load(plugin_at("good"), diagnostics);
  CHECK(document::describe(*catalog.find(Role::process_model, "rest")) ==
        "good/rest: process model (plugin good 1.2.3)\n"
        "  Nothing moves\n"
        "\n"
        "Ports (\"blocks\")\n"
        "  x      vector:*:*  advances  required  what rests\n"
        "  other  vector:1:m  reads     optional  looked at\n"
        "\n"
        "Fields of its input\n"
        "  wx  rad/s  rate  required  angular rate\n"
        "\n"
        "Parameters\n"
        "  q  as many as x, unit of x/sqrt(s), >= 0  required  noise\n");
  CHECK(document::describe(*catalog.find(Role::state_block, "still")) ==
        "good/still: state block (plugin good 1.2.3)\n"
        "  One number that is what it is\n"
        "  Source: none\n"
        "  Kind: vector:1:m\n"
        "\n"
        "Parameters\n"
        "  length  m, >= 0  default \"2 km\"  how long\n"
        "\n"
        "Example\n"
        "  {\"length\": \"3 m\", \"sigma\": \"1 m\"}\n");
  const auto json = document::describe_json(*catalog.find(Role::process_model, "rest"));
  CHECK(
      json["parameters"].dump() ==
      R"json([{"name":"q","type":"vector","unit":"@x/sqrt(s)","required":true,"at_least":0.0,"size_of_port":"x","text":"noise"}])json");
  CHECK(json["ports"][1]["required"] == false);
  CHECK(json["fields"][0]["kind"] == "rate");
}

TEST_CASE("a skeleton holds what has to be filled in", "[catalog]") {
  Catalog catalog;
  Diagnostics diagnostics;
  catalog.load(plugin_at("good"), diagnostics);
  const std::string expected = R"({
  "binnacle": 1,
  "sources": {
    "thrower": {
      "type": "good/thrower",  // Throws
      "what": "nothing"  // one of 'nothing', 'component_error', 'data_error', 'own_error', 'int': what is thrown
    }
  },
  "filters": {
    "filter": {
      "blocks": {
        "still": {
          "type": "good/still",  // One number that is what it is
          "length": "3 m",  // m, >= 0: how long
          "sigma": "1 m",  // initial standard deviation, one for all or by component
          "init": {
            "channel": "CHANNEL"
          }
        }
      },
      "process": {
        "rest": {
          "type": "good/rest",  // Nothing moves
          "blocks": {
            "x": "BLOCK"  // vector:*:*: what rests
          },
          "input": "CHANNEL",
          "q": 1  // as many as x, unit of x/sqrt(s), >= 0: noise
        }
      }
    }
  }
}
)";
  CHECK(document::skeleton(catalog.types()) == expected);
}

}  // namespace catalog_test
