// SPDX-License-Identifier: MIT
#include "arguments.hpp"

#include <algorithm>
#include <cmath>
#include <iostream>

#include <CLI/CLI.hpp>

#include "crease/stepper/suggest.hpp"

namespace crease::cli {
namespace {

// Verbs that are named already, so that scripts can be written, but do nothing yet.
constexpr const char* later_verbs[][2] = {
    {"study", "Run a matrix of scene variants and write error against run time (not available yet)"},
    {"view", "Make a page that plays a run in a browser (not available yet)"},
    {"export", "Convert the frames of a run to another format (not available yet)"},
};

std::string needs_path_and_value(const std::string& text) {
  const size_t equals = text.find('=');
  const bool right = equals != std::string::npos && equals > 0;
  return right ? "" : "expected path=value, such as contact.threshold=0.002, got '" + text + "'";
}

std::string needs_time(const std::string& text) {
  double time = 0;
  const bool right = CLI::detail::lexical_cast(text, time) && std::isfinite(time) && time >= 0;
  return right ? "" : "expected a time in seconds, got '" + text + "'";
}

std::string needs_threads(const std::string& text) {
  constexpr int most = 256;  // beyond that a number is a slip
  int threads = 0;
  const bool right = CLI::detail::lexical_cast(text, threads) && threads >= 1 && threads <= most;
  return right ? "" : "expected a number of threads from 1 to " + std::to_string(most) + ", got '" + text + "'";
}

void add_scene(CLI::App& verb, Arguments& arguments, std::vector<std::string>& sets) {
  verb.add_option("SCENE", arguments.scene, "Scene file, or the name of a shipped scene (see crease list)")->required();
  verb.add_option("--set", sets, "Override a value: a dotted path, =, a JSON value; may be given again")
      ->type_name("PATH=VALUE")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->check(needs_path_and_value);
}

void add_verbs(CLI::App& app, Arguments& arguments, std::vector<std::string>& sets) {
  CLI::App* run = app.add_subcommand("run", "Simulate a scene and write a directory of results");
  add_scene(*run, arguments, sets);
  run->add_option("-o,--output", arguments.output, "Directory to write")->type_name("DIR")->required();
  run->add_option("--until", arguments.until, "Stop at this time")->type_name("SECONDS")->check(needs_time);
  CLI::Option* resume = run->add_flag("--resume", arguments.resume, "Continue from the last checkpoint in DIR");
  run->add_flag("--force", arguments.force, "Write into DIR although it is not empty")->excludes(resume);
  run->add_option("--threads", arguments.threads, "Threads to use; any number gives the same result")
      ->type_name("N")
      ->check(needs_threads);
  run->add_flag("--quiet", arguments.quiet, "Print errors only");

  CLI::App* check =
      app.add_subcommand("check", "Print a scene with all defaults filled in, or everything wrong with it");
  add_scene(*check, arguments, sets);

  CLI::App* list = app.add_subcommand("list", "List the scenes that ship");
  list->add_flag("--paths", arguments.paths, "Print their files instead");
  app.add_subcommand("schema", "Print the JSON Schema of the scene format");
  for (const auto& [name, what] : later_verbs) app.add_subcommand(name, what)->allow_extras();
}

std::vector<std::string> verb_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* verb : app.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(verb->get_name());
  return names;
}

int usage_error(const std::string& message, const std::string& verb = "") {
  std::cerr << "crease: " << message << "\nTry 'crease " << verb << (verb.empty() ? "" : " ") << "--help'.\n";
  return ExitUsage;
}

// "; did you mean ..." for the first option that the verb does not know.
std::string option_hint(const CLI::App& verb, int argc, const char* const* argv) {
  std::vector<std::string> known;
  for (const CLI::Option* option : verb.get_options())
    for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
  for (int i = 2; i < argc; ++i) {
    const std::string word = argv[i], name = word.substr(0, word.find('='));
    if (name.size() < 3 || !name.starts_with("--") || std::find(known.begin(), known.end(), name) != known.end())
      continue;
    return suggestion(name, known);
  }
  return "";
}

}  // namespace

std::variant<Arguments, int> parse_arguments(int argc, const char* const* argv) {
  CLI::App app{"Cloth that slides over sharp edges and corners (Eulerian-on-Lagrangian)", "crease"};
  app.set_version_flag("--version", "crease " CREASE_VERSION);
  app.require_subcommand(1);
  Arguments arguments;
  std::vector<std::string> sets;
  add_verbs(app, arguments, sets);

  if (argc < 2) {
    std::cerr << app.help();
    return ExitUsage;
  }
  const std::string first = argv[1];
  const std::vector<std::string> verbs = verb_names(app);
  if (!first.starts_with('-') && std::find(verbs.begin(), verbs.end(), first) == verbs.end())
    return usage_error("unknown verb \"" + first + "\"" + suggestion(first, verbs));
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    app.exit(success, std::cout, std::cerr);
    return std::cout.flush() ? ExitDone : ExitFileTrouble;
  } catch (const CLI::ParseError& error) {
    const bool has_verb = !first.starts_with('-');
    const bool unknown_word = dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr;
    return usage_error(
        error.what() + (has_verb && unknown_word ? option_hint(*app.get_subcommand(first), argc, argv) : ""),
        has_verb ? first : "");
  }
  arguments.verb = app.get_subcommands().front()->get_name();
  for (const std::string& set : sets) {
    const size_t equals = set.find('=');
    arguments.overrides.emplace_back(set.substr(0, equals), set.substr(equals + 1));
  }
  for (int i = 0; i < argc; ++i) arguments.command_line += (i ? " " : "") + std::string(argv[i]);
  return arguments;
}

}  // namespace crease::cli
