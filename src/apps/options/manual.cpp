/** @file
 * Manual pages and completions, made from the tables that --help is made from.
 */
#include "apps/options/manual.h"

#include <sstream>

#include "recurse/core/io/error.h"

namespace recurse::apps {

namespace {

/** Escapes text for troff. */
std::string troff(const std::string& text) {
  std::string out;
  bool lineStart = true;
  for (const char c : text) {
    if (lineStart && (c == '.' || c == '\'')) out += "\\&";
    if (c == '\\')
      out += "\\e";
    else if (c == '-')
      out += "\\-";
    else
      out += c;
    lineStart = c == '\n';
  }
  return out;
}

std::string fullName(const CLI::App& app) {
  return app.get_parent() ? fullName(*app.get_parent()) + "-" + app.get_name() : app.get_name();
}

/** Names of an option, as "-o, --output", or of a positional. */
std::string namesOf(const CLI::Option& option) {
  std::string out;
  const auto add = [&](const std::string& name) { out += (out.empty() ? "" : ", ") + name; };
  for (const std::string& name : option.get_snames()) add("-" + name);
  for (const std::string& name : option.get_lnames()) add("--" + name);
  return out.empty() ? option.get_name() : out;
}

std::string argumentOf(const CLI::Option& option) {
  return option.get_type_size() == 0 ? "" : option.get_type_name();
}

std::vector<const CLI::Option*> optionsOf(const CLI::App& app) {
  std::vector<const CLI::Option*> out;
  for (const CLI::Option* option : app.get_options())
    if (!option->get_group().empty()) out.push_back(option);
  return out;
}

std::vector<const CLI::App*> subcommandsOf(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App*) { return true; });
}

/** The values of an option that takes one of a few, such as {auto,plain,json,off}. */
std::vector<std::string> valuesOf(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const size_t open = type.find('{'), close = type.rfind('}');
  std::vector<std::string> out;
  if (open == std::string::npos || close == std::string::npos) return out;
  std::istringstream list(type.substr(open + 1, close - open - 1));
  for (std::string value; std::getline(list, value, ',');) out.push_back(value);
  return out;
}

std::string joinedWords(const std::vector<std::string>& words) {
  std::string out;
  for (const std::string& word : words) out += (out.empty() ? "" : " ") + word;
  return out;
}

std::vector<std::string> longNames(const CLI::App& app) {
  std::vector<std::string> out;
  for (const CLI::Option* option : optionsOf(app))
    for (const std::string& name : option->get_lnames()) out.push_back("--" + name);
  return out;
}

/** Text in single quotes; `quote` replaces single quotes within. */
std::string quoted(const std::string& text, const std::string& quote) {
  std::string out;
  for (const char c : text) out += c == '\'' ? quote : std::string(1, c);
  return "'" + out + "'";
}

std::string bash(const CLI::App& app) {
  std::string commands, cases;
  for (const CLI::App* sub : subcommandsOf(app)) {
    commands += (commands.empty() ? "" : " ") + sub->get_name();
    std::string values;
    for (const CLI::Option* option : optionsOf(*sub))
      if (const auto list = valuesOf(*option); !list.empty())
        for (const std::string& name : option->get_lnames())
          values +=
              "        " + sub->get_name() + "\\ --" + name + ") words='" + joinedWords(list) + "' ;;\n";
    cases += values;
    cases += "        " + sub->get_name() + "\\ *) [[ $word == -* ]] && words='" +
             joinedWords(longNames(*sub)) + "' ;;\n";
  }
  const std::string& name = app.get_name();
  return "# Completion of " + name + " for bash.\n_" + name +
         "() {\n"
         "    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} words=\n"
         "    if ((COMP_CWORD == 1)); then\n        words='" +
         commands + " --help --version'\n    else\n        case \"${COMP_WORDS[1]} $before\" in\n" + cases +
         "        esac\n    fi\n"
         "    COMPREPLY=()\n"
         "    [[ $words ]] && mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$word\")\n"
         "}\ncomplete -o bashdefault -o default -F _" +
         name + " " + name + "\n";
}

std::string zsh(const CLI::App& app) {
  const auto escaped = [](const std::string& text) {
    std::string out;
    for (const char c : text)
      out += (c == '[' || c == ']' || c == ':' || c == '\\' ? "\\" : "") + std::string(1, c);
    return quoted(out, "'\\''");
  };
  std::string commands, cases;
  for (const CLI::App* sub : subcommandsOf(app)) {
    commands += "        " + escaped(sub->get_name()).substr(0, sub->get_name().size() + 1) + ":" +
                escaped(sub->get_description()).substr(1) + "\n";
    cases += "        " + sub->get_name() + ")\n            _arguments";
    for (const CLI::Option* option : optionsOf(*sub))
      for (const std::string& name : option->get_lnames()) {
        std::string text = escaped("--" + name);
        text.pop_back();
        const std::string description = escaped(option->get_description());
        text += "[" + description.substr(1, description.size() - 2) + "]";
        if (!argumentOf(*option).empty()) {
          const auto values = valuesOf(*option);
          text += values.empty() ? ":argument:_files" : ":value:(" + joinedWords(values) + ")";
        }
        cases += " \\\n                " + text + "'";
      }
    cases += " \\\n                '*:file:_files'\n            ;;\n";
  }
  const std::string& name = app.get_name();
  return "#compdef " + name + "\n_" + name + "() {\n    local -a commands=(\n" + commands +
         "    )\n    if ((CURRENT == 2)); then\n        _describe command commands\n        return\n    fi\n"
         "    local command=${words[2]}\n    shift words\n    ((CURRENT--))\n    case $command in\n" +
         cases + "    esac\n}\n_" + name + " \"$@\"\n";
}

std::string fish(const CLI::App& app) {
  const std::string& name = app.get_name();
  std::string out = "# Completion of " + name + " for fish.\n";
  for (const CLI::App* sub : subcommandsOf(app)) {
    out += "complete -c " + name + " -n __fish_use_subcommand -f -a " + sub->get_name() + " -d " +
           quoted(sub->get_description(), "\\'") + "\n";
    for (const CLI::Option* option : optionsOf(*sub))
      for (const std::string& longName : option->get_lnames()) {
        out += "complete -c " + name + " -n '__fish_seen_subcommand_from " + sub->get_name() + "' -l " +
               longName;
        for (const std::string& s : option->get_snames()) out += " -s " + s;
        if (const auto values = valuesOf(*option); !values.empty())
          out += " -x -a '" + joinedWords(values) + "'";
        else if (!argumentOf(*option).empty())
          out += " -r";
        out += " -d " + quoted(option->get_description(), "\\'") + "\n";
      }
  }
  return out;
}

} // namespace

std::string manualPage(const CLI::App& app, const std::string& version) {
  const std::string name = fullName(app);
  std::string command = name;
  if (app.get_parent()) command[app.get_parent()->get_name().size()] = ' ';
  std::string out = ".TH " + name + " 1 \"\" \"Recurse " + version + "\" \"User Commands\"\n.SH NAME\n" +
                    troff(name) + " \\- " + troff(app.get_description()) + "\n.SH SYNOPSIS\n.B " +
                    troff(command) + "\n";
  const auto subcommands = subcommandsOf(app);
  out += subcommands.empty() ? "[OPTIONS]" : "SUBCOMMAND";
  std::string positionals, options;
  for (const CLI::Option* option : optionsOf(app)) {
    const std::string argument = argumentOf(*option);
    const bool isPositional = option->get_positional();
    if (isPositional)
      out += " " + troff(option->get_required() ? option->get_name() : "[" + option->get_name() + "]");
    (isPositional ? positionals : options) += ".TP\n.BR \"" + troff(namesOf(*option)) + "\"" +
                                              (argument.empty() ? "" : " \" " + troff(argument) + "\"") +
                                              "\n" + troff(option->get_description()) + "\n";
  }
  out += "\n";
  if (!positionals.empty()) out += ".SH ARGUMENTS\n" + positionals;
  if (!subcommands.empty()) {
    out += ".SH SUBCOMMANDS\n";
    for (const CLI::App* sub : subcommands)
      out += ".TP\n.B " + troff(sub->get_name()) + "\n" + troff(sub->get_description()) + "; see " +
             troff(fullName(*sub)) + "(1)\n";
  }
  out += ".SH OPTIONS\n" + options;
  if (const std::string footer = app.get_footer(); !footer.empty())
    out += ".SH NOTES\n.nf\n" + troff(footer) + "\n.fi\n";
  if (app.get_parent()) out += ".SH SEE ALSO\n" + troff(fullName(*app.get_parent())) + "(1)\n";
  return out;
}

std::string completion(const CLI::App& app, const std::string& shell) {
  if (shell == "bash") return bash(app);
  if (shell == "zsh") return zsh(app);
  if (shell == "fish") return fish(app);
  throw Error("--completion: '" + shell + "' is none of bash, zsh, fish", ExitStatus::BAD_USAGE);
}

} // namespace recurse::apps
