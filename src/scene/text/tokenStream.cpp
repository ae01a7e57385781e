/** @file
 * Stack of open files.
 */
#include "scene/text/tokenStream.h"

#include <cctype>
#include <cmath>

#include "recurse/core/io/text.h"

namespace recurse::sceneFile {

TokenStream::TokenStream(const Source& source, SourceFiles& files, ErrorLog& log, IncludeCount& includes,
                         const TokenStream* outer)
    : files(files), log(log), includes(includes), outer(outer) {
  stack.push_back({Lexer(source), {}});
}

Token TokenStream::next() {
  Token token = stack.back().lexer.next();
  if (const std::optional<Token>& reference = stack.back().reference) {
    token.source = reference->source;
    token.line = reference->line;
    token.column = reference->column;
  }
  if (token.kind == TokenKind::STRING && !files.tracks.empty() && token.text.find('$') != std::string::npos)
    insertTracks(token);
  return token;
}

const Token& TokenStream::peek() {
  while (!ahead) {
    const Token token = next();
    if (token.isWord("Include"))
      include(token);
    else if (token.kind == TokenKind::WORD && token.text.front() == '$')
      spliceTrack(token);
    else if (token.kind == TokenKind::END && stack.size() > 1)
      stack.pop_back();
    else
      ahead = token;
  }
  return *ahead;
}

Token TokenStream::take() {
  const Token token = peek();
  // END is not consumed, so that every caller sees it.
  if (token.kind != TokenKind::END) ahead.reset();
  return token;
}

void TokenStream::appendNumbers(std::vector<double>& out) {
  if (ahead && looksLikeNumber(*ahead)) {
    out.push_back(numberValue(*ahead));
    ahead.reset();
  }
  if (!ahead) stack.back().lexer.appendNumbers(out);
}

void TokenStream::include(const Token& directive) {
  // The name must be in the same file: an Include at the end of a file is incomplete.
  const Token name = next();
  if (name.kind != TokenKind::STRING) {
    log.error(name.kind == TokenKind::END ? directive.location() : name.location(),
              "Include needs a file name in quotes, found " + name.shown());
    if (name.kind != TokenKind::END) ahead = name;
    return;
  }
  if (const Source* source = resolve(name, "Include")) stack.push_back({Lexer(*source), {}});
}

void TokenStream::spliceTrack(const Token& reference) {
  std::string_view name = reference.text.substr(1);
  if (name.starts_with('{') && name.ends_with('}')) name = name.substr(1, name.size() - 2);
  const auto found = files.tracks.find(name);
  if (found == files.tracks.end()) {
    std::vector<std::string> names;
    for (const auto& [name, text] : files.tracks) names.push_back("$" + name);
    std::string accepted;
    for (const std::string& name : nearestNames(std::string(reference.text.substr(0, 64)), names))
      accepted += (accepted.empty() ? "" : " ") + name;
    throw SceneError(reference.location(), "there is no track " + reference.shown() + " yet",
                     accepted.empty() ? "the name of an Animate directive above" : accepted);
  }
  ++found->second.uses;
  stack.push_back({Lexer(*found->second.source), reference});
}

void TokenStream::insertTracks(Token& string) {
  const std::string_view text = string.text;
  const auto fail = [&](size_t at, const std::string& message, const std::string& accepted) {
    Token place = string;
    place.column += static_cast<int64_t>(at) + 1; // + 1 for the quote
    throw SceneError(place.location(), message, accepted);
  };
  const auto endOf = [&](size_t from, const auto& belongs) {
    while (from < text.size() && belongs(static_cast<unsigned char>(text[from]))) ++from;
    return from;
  };
  const auto isDigit = [](unsigned char c) { return std::isdigit(c) != 0; };
  std::string out;
  size_t copied = 0, dollar = 0;
  for (; (dollar = text.find('$', dollar)) != std::string_view::npos; ++dollar) {
    const bool braces = text.substr(dollar + 1, 1) == "{";
    const size_t begin = dollar + (braces ? 2 : 1);
    const size_t nameEnd = braces ? std::min(text.find('}', begin), text.size())
                                  : endOf(begin, [](unsigned char c) { return std::isalnum(c) || c == '_'; });
    const auto found = files.tracks.find(text.substr(begin, nameEnd - begin));
    if (found == files.tracks.end() || (braces && nameEnd == text.size())) continue;
    const std::string name(text.substr(dollar, nameEnd - dollar));
    if (found->second.values.size() != 1)
      fail(dollar, "track " + name + " has " + std::to_string(found->second.values.size()) + " numbers",
           "in a string, a track of one number");
    size_t end = nameEnd + (braces ? 1 : 0);
    int digits = 1;
    if (end + 1 < text.size() && text[end] == '%' && isDigit(static_cast<unsigned char>(text[end + 1]))) {
      constexpr size_t MOST_DIGITS = 2;
      const size_t stop = endOf(end + 1, isDigit);
      const std::string width(text.substr(end + 1, stop - end - 1));
      if (width[0] != '0' || width.size() > MOST_DIGITS || text.substr(stop, 1) != "d")
        fail(end, "the width of the number " + name + " cannot be read", "%02d to %09d");
      digits = std::stoi(width);
      end = stop + 1;
    }
    out += text.substr(copied, dollar - copied);
    // Adding zero removes the sign of a negative zero.
    out += formatted("%0*.0f", digits, std::round(found->second.values[0]) + 0.0);
    copied = end;
    dollar = end - 1;
    ++found->second.uses;
  }
  if (copied == 0) return;
  out += text.substr(copied);
  string.text = files.keep(std::move(out));
}

void TokenStream::collectOpen(std::vector<const Source*>& chain) const {
  if (outer) outer->collectOpen(chain);
  for (const Open& open : stack) chain.push_back(&open.lexer.source());
}

const Source* TokenStream::resolve(const Token& name, const char* directive) {
  const std::string what = directive;
  std::vector<const Source*> chain;
  collectOpen(chain);
  try {
    const std::string fileName = name.value();
    const Source*& known = files.included[{name.source->directory, fileName}];
    if (!known) {
      std::string tried;
      const std::string path = findFile(fileName, name.source->directory, files.topDirectory, tried);
      if (path.empty()) {
        log.error(name.location(), what + ": no such file: " + name.shown(),
                  "an existing file; tried " + tried);
        return nullptr;
      }
      known = &files.open(path);
    }
    const Source& source = *known;
    const bool isEnough = includes.bytes > IncludeCount::MAX_BYTES;
    includes.bytes += std::max(source.text->text.size(), IncludeCount::MIN_FILE_BYTES);
    if (includes.bytes > IncludeCount::MAX_BYTES) {
      if (!isEnough)
        log.error(name.location(), "the included files are too long in total",
                  "up to 64 GiB, where each file counts as at least 64 KiB");
      return nullptr;
    }
    for (size_t i = 0; i < chain.size(); ++i) {
      if (chain[i]->canonical != source.canonical) continue;
      std::string names;
      for (size_t k = i; k < chain.size(); ++k) names += chain[k]->text->name + " includes ";
      log.error(name.location(), what + " would repeat forever: " + names + source.text->name);
      return nullptr;
    }
    if (chain.size() >= IncludeCount::MAX_DEPTH) {
      log.error(name.location(),
                "files are included more than " + std::to_string(IncludeCount::MAX_DEPTH) + " levels deep");
      return nullptr;
    }
    return &source;
  } catch (const SceneError& e) {
    log.report(e);
  } catch (const Error& e) {
    log.error(name.location(), what + ": " + e.what());
  }
  return nullptr;
}

} // namespace recurse::sceneFile
