/** @file
 * Parser of parameter lists.
 */
#include "scene/parameters/parameterParser.h"

#include "scene/text/directiveNames.h"
#include "scene/text/pbrt3.h"

namespace recurse::sceneFile {

namespace {

struct TypeWord {
  const char* word;
  ValueKind kind;
};

constexpr TypeWord TYPE_WORDS[] = {
    {"bool", ValueKind::BOOLEANS},   {"integer", ValueKind::NUMBERS},   {"float", ValueKind::NUMBERS},
    {"point2", ValueKind::NUMBERS},  {"vector2", ValueKind::NUMBERS},   {"point3", ValueKind::NUMBERS},
    {"point", ValueKind::NUMBERS},   {"vector3", ValueKind::NUMBERS},   {"vector", ValueKind::NUMBERS},
    {"normal", ValueKind::NUMBERS},  {"normal3", ValueKind::NUMBERS},   {"string", ValueKind::STRINGS},
    {"rgb", ValueKind::NUMBERS},     {"spectrum", ValueKind::SPECTRUM}, {"blackbody", ValueKind::NUMBERS},
    {"texture", ValueKind::STRINGS},
};

/** Capacity above which vectors release memory that they do not need [values]. */
constexpr size_t WORTH_SHRINKING = 1 << 16;

const char* expectedName(ValueKind kind) {
  switch (kind) {
  case ValueKind::NUMBERS:
    return "a number";
  case ValueKind::STRINGS:
    return "a string in quotes";
  case ValueKind::BOOLEANS:
    return "true or false";
  case ValueKind::SPECTRUM:
    return "numbers, or the name of a spectrum in quotes";
  case ValueKind::UNKNOWN:
    break;
  }
  return "a value";
}

/** True for a string like "float radius", which must be the next parameter and not a value. */
bool looksLikeDeclaration(const Token& token) {
  const size_t space = token.text.find(' ');
  return token.kind == TokenKind::STRING && space != std::string_view::npos &&
         valueKindOf(token.text.substr(0, space)) != ValueKind::UNKNOWN;
}

/** Appends one value. Throws SceneError when it is of a different kind. */
void addValue(const Token& token, ValueKind kind, ParsedParameter& out) {
  const bool quoted = token.kind == TokenKind::STRING;
  switch (kind) {
  case ValueKind::UNKNOWN:
    return; // reported already
  case ValueKind::NUMBERS:
    if (!quoted) {
      out.numbers.push_back(numberValue(token));
      return;
    }
    break;
  case ValueKind::STRINGS:
    if (quoted) {
      out.strings.push_back(token.value());
      return;
    }
    break;
  case ValueKind::BOOLEANS:
    if (token.text == "true" || token.text == "false") {
      out.booleans.push_back(token.text == "true");
      return;
    }
    break;
  case ValueKind::SPECTRUM:
    if (quoted && out.numbers.empty()) {
      out.strings.push_back(token.value());
      return;
    }
    if (!quoted && out.strings.empty()) {
      out.numbers.push_back(numberValue(token));
      return;
    }
    break;
  }
  throw SceneError(token.location(), "parameter \"" + out.name + "\" of type " + out.type + ": expected " +
                                         expectedName(kind) + ", found " + token.shown());
}

void skipBadDeclaration(TokenStream& tokens) {
  // Skips the values of a declaration that was not understood.
  if (tokens.peek().kind == TokenKind::OPEN) {
    while (tokens.peek().kind != TokenKind::CLOSE && tokens.peek().kind != TokenKind::END &&
           !isDirectiveName(tokens.peek()))
      tokens.take();
    if (tokens.peek().kind == TokenKind::CLOSE) tokens.take();
  } else if (!isDirectiveName(tokens.peek()) && tokens.peek().kind != TokenKind::CLOSE) {
    tokens.take();
  }
}

/** Parses a value without brackets. */
void parseSingleValue(TokenStream& tokens, ValueKind kind, ErrorLog& log, ParsedParameter& out) {
  const bool numeric = kind == ValueKind::NUMBERS;
  const Token first = tokens.peek();
  if (first.kind == TokenKind::END || first.kind == TokenKind::CLOSE || isDirectiveName(first) ||
      (numeric && looksLikeDeclaration(first))) {
    log.error(first.kind == TokenKind::END ? out.location : first.location(),
              "parameter \"" + out.name + "\" has no value");
    return;
  }
  tokens.take();
  try {
    addValue(first, kind, out);
  } catch (const SceneError& e) {
    log.report(e);
    out.isBad = true;
  }
  if (!looksLikeNumber(tokens.peek())) return;
  if (kind != ValueKind::UNKNOWN)
    log.error(tokens.peek().location(),
              "parameter \"" + out.name + "\": several values need brackets around them: [ ... ]");
  // Further numbers are taken as values, so that they cause no more errors.
  while (looksLikeNumber(tokens.peek())) {
    const Token more = tokens.take();
    try {
      if (numeric) out.numbers.push_back(numberValue(more));
    } catch (const SceneError& e) {
      log.report(e);
    }
  }
}

/** Parses the values behind an opening bracket, and the closing one. */
void parseList(TokenStream& tokens, ValueKind kind, ErrorLog& log, ParsedParameter& out) {
  const bool numeric = kind == ValueKind::NUMBERS;
  for (;;) {
    if (numeric && !out.isBad) {
      try {
        tokens.appendNumbers(out.numbers);
      } catch (const SceneError& e) {
        log.report(e);
        out.isBad = true;
        tokens.take();
      }
    }
    const Token token = tokens.peek();
    if (token.kind == TokenKind::CLOSE) {
      tokens.take();
      return;
    }
    const bool endsHere = token.kind == TokenKind::END || isDirectiveName(token);
    if (endsHere || (numeric && looksLikeDeclaration(token))) {
      log.error(endsHere ? out.valueLocation : token.location(),
                "the list of values of \"" + out.name + "\" is not closed by ']'");
      return;
    }
    tokens.take();
    if (token.kind == TokenKind::OPEN && out.isBad) continue;
    try {
      if (!out.isBad) addValue(token, kind, out);
    } catch (const SceneError& e) {
      log.report(e);
      out.isBad = true;
    }
  }
}

} // namespace

const std::vector<std::string>& parameterTypeWords() {
  static const std::vector<std::string> WORDS = [] {
    std::vector<std::string> words;
    for (const TypeWord& t : TYPE_WORDS) words.emplace_back(t.word);
    return words;
  }();
  return WORDS;
}

ValueKind valueKindOf(std::string_view typeWord) {
  for (const TypeWord& t : TYPE_WORDS)
    if (typeWord == t.word) return t.kind;
  return ValueKind::UNKNOWN;
}

void splitDeclaration(const Token& token, std::string& type, std::string& name, ErrorLog& log) {
  const std::string text = token.value();
  std::vector<std::string> words;
  for (size_t i = 0; i < text.size();) {
    const size_t begin = text.find_first_not_of(" \t", i);
    if (begin == std::string::npos) break;
    const size_t end = std::min(text.find_first_of(" \t", begin), text.size());
    words.push_back(text.substr(begin, end - begin));
    i = end;
  }
  if (words.size() < 2)
    throw SceneError(token.location(), "expected the type and name of a parameter, found " + token.shown(),
                     "such as \"float radius\"");
  if (words.size() > 2)
    log.warning(token.location(), "only the type and name of " + token.shown() + " are used");
  type = words[0];
  name = words[1];
}

void parseValues(TokenStream& tokens, ErrorLog& log, ParsedParameter& out) {
  const ValueKind kind = valueKindOf(out.type);
  const Token first = tokens.peek();
  out.valueLocation = first.location();
  if (first.kind != TokenKind::OPEN) {
    parseSingleValue(tokens, kind, log, out);
    return;
  }
  tokens.take();
  out.valueLocation = tokens.peek().location();
  parseList(tokens, kind, log, out);
  if (out.numbers.capacity() > WORTH_SHRINKING && out.numbers.capacity() > out.numbers.size() * 5 / 4)
    out.numbers.shrink_to_fit();
}

std::vector<ParsedParameter> parseParameters(TokenStream& tokens, ErrorLog& log,
                                             const std::string& directory) {
  std::vector<ParsedParameter> list;
  while (tokens.peek().kind == TokenKind::STRING) {
    const Token token = tokens.take();
    ParsedParameter p;
    p.location = token.location();
    try {
      splitDeclaration(token, p.type, p.name, log);
    } catch (const SceneError& e) {
      log.report(e);
      skipBadDeclaration(tokens);
      continue;
    }
    const bool known = valueKindOf(p.type) != ValueKind::UNKNOWN;
    if (!known) {
      std::string message = "unknown parameter type '" + p.type + "' of \"" + p.name + "\"";
      if (const char* hint = pbrt3::parameterTypeHint(p.type)) {
        message += std::string("; ") + hint;
        log.sawPbrt3Type = true;
      } else {
        const auto near = nearestNames(p.type, parameterTypeWords(), 1);
        if (!near.empty()) message += "; did you mean '" + near[0] + "'?";
      }
      std::string accepted;
      for (const std::string& word : parameterTypeWords()) accepted += (accepted.empty() ? "" : " ") + word;
      log.error(p.location, message, accepted);
    }
    if (token.source->directory != directory) p.directory = token.source->directory;
    parseValues(tokens, log, p);
    if (known) list.push_back(std::move(p));
  }
  return list;
}

} // namespace recurse::sceneFile

namespace recurse {

ParsedDirective parseParameterText(const std::string& plugIn, const std::string& text) {
  using namespace sceneFile;
  Diagnostics diagnostics;
  ErrorLog log(diagnostics);
  SourceFiles files;
  IncludeCount includes;
  ParsedDirective out;
  out.type = plugIn;
  try {
    TokenStream tokens(files.addText(text, "parameters of " + plugIn, ""), files, log, includes);
    out.location = tokens.peek().location();
    out.parameters = parseParameters(tokens, log, "");
    if (tokens.peek().kind != TokenKind::END)
      log.error(tokens.peek().location(), "expected a parameter, found " + tokens.peek().shown());
  } catch (const SceneError& e) {
    for (const Diagnostic& d : e.diagnostics()) diagnostics.error(d.location, d.message, d.accepted);
  } catch (const TooManyErrors&) {
    // reported in the diagnostics
  }
  diagnostics.throwIfErrors();
  return out;
}

} // namespace recurse
