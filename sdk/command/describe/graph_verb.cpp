// SPDX-License-Identifier: Apache-2.0
// graph: the composition as DOT, or through Graphviz as SVG; the sparsity of Φ, Qd and H as SVG.
#include <cstdio>

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include "atomic_file.hpp"
#include "document/document.hpp"
#include "dot.hpp"
#include "output.hpp"
#include "score/sections.hpp"
#include "sparsity_svg.hpp"
#include "verbs.hpp"

namespace binnacle::command {

namespace {

constexpr int not_found = 127;  // what a shell says, and here the child, where there is no such program

struct FileCloser {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, FileCloser>;

/// A file without a name that both this process and Graphviz have.
File scratch_file() {
  File file(std::tmpfile());
  if (!file) throw OutputError("no temporary file could be made");
  return file;
}

int run_graphviz(std::FILE* in, std::FILE* out) {
  const pid_t child = fork();
  if (child < 0) throw OutputError("no process could be started for Graphviz");
  if (child == 0) {
    dup2(fileno(in), STDIN_FILENO);
    dup2(fileno(out), STDOUT_FILENO);
    execlp("dot", "dot", "-Tsvg", static_cast<char*>(nullptr));
    _exit(not_found);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

std::string all_in(std::FILE* file) {
  std::string text;
  char buffer[4096];
  std::rewind(file);
  while (const auto count = std::fread(buffer, 1, sizeof buffer, file)) text.append(buffer, count);
  return text;
}

void write_svg(const std::string& dot, const std::string& path) {
  AtomicFile svg(path);
  const File in = scratch_file(), out = scratch_file();
  std::fwrite(dot.data(), 1, dot.size(), in.get());
  std::rewind(in.get());
  const int status = run_graphviz(in.get(), out.get());
  if (status == not_found)
    throw UsageError("--svg needs Graphviz, and there is no `dot` on the PATH; install it: apt-get install graphviz");
  if (status != 0) throw OutputError(fmt::format("Graphviz' `dot` failed with status {}", status));
  svg.write(all_in(out.get()));
  svg.commit();
}

struct GraphVerbOptions {
  std::string config_path;
  ConfigOptions config;
  std::string svg;
  std::string sparsity;
  bool json = false;
};

int graph(const GraphVerbOptions& options) {
  const auto composition = score::load(options.config_path, options.config.load_options(options.config_path));
  const Json explained = document::explain(*composition);
  const std::string dot = dot_text(explained);
  if (!options.sparsity.empty()) {
    AtomicFile file(options.sparsity);
    file.write(sparsity_svg(explained));
    file.commit();
  }
  if (!options.svg.empty())
    write_svg(dot, options.svg);
  else if (!options.sparsity.empty())
    return ok;
  else if (options.json)
    print_json({{"dot", dot}});
  else
    print(dot);
  return ok;
}

}  // namespace

Verb graph_verb(CLI::App& command) {
  const auto options = std::make_shared<GraphVerbOptions>();
  CLI::App* app = add_verb(command, "graph");
  app->add_option("CONFIG", options->config_path, "The config")->required();
  options->config.add_to(*app);
  options->config.add_variant_to(*app);
  app->add_option("--svg", options->svg, "Draw the graph with Graphviz instead of printing DOT")->type_name("FILE.svg");
  app->add_option("--sparsity", options->sparsity,
                  "Draw the state layout and the non-zero blocks of the transition, noise and measurement matrices")
      ->type_name("FILE.svg");
  app->add_flag("--json", options->json, "Print the DOT text as a JSON object");
  return {app, [options] { return graph(*options); }};
}

}  // namespace binnacle::command
