/** @file
 * The stack of open files.
 */
#include "scene/tokenStream.h"

namespace recurse::sceneFile {

TokenStream::TokenStream(const Source& source, SourceFiles& files, ErrorLog& log, IncludeCount& includes,
                         const TokenStream* outer)
    : files(files), log(log), includes(includes), outer(outer) {
  stack.emplace_back(source);
}

const Token& TokenStream::peek() {
  while (!ahead) {
    const Token token = stack.back().next();
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
  // The end stays, so that every reader meets it.
  if (token.kind != TokenKind::END) ahead.reset();
  return token;
}

void TokenStream::appendNumbers(std::vector<double>& out) {
  if (ahead && looksLikeNumber(*ahead)) {
    out.push_back(numberValue(*ahead));
    ahead.reset();
  }
  if (!ahead) stack.back().appendNumbers(out);
}

void TokenStream::include(const Token& directive) {
  // Only the same file can hold the name: an Include at the end of a file is incomplete.
  const Token name = stack.back().next();
  if (name.kind != TokenKind::STRING) {
    log.error(name.kind == TokenKind::END ? directive.location() : name.location(),
              "Include needs a file name in quotes, found " + name.shown());
    if (name.kind != TokenKind::END) ahead = name;
    return;
  }
  if (const Source* source = resolve(name, "Include")) stack.emplace_back(*source);
}

void TokenStream::spliceTrack(const Token& reference) {
  const auto found = files.tracks.find(reference.text.substr(1));
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
  stack.emplace_back(*found->second.source);
}

void TokenStream::collectOpen(std::vector<const Source*>& chain) const {
  if (outer) outer->collectOpen(chain);
  for (const Lexer& lexer : stack) chain.push_back(&lexer.source());
}

const Source* TokenStream::resolve(const Token& name, const char* directive) {
  const std::string what = directive;
  std::vector<const Source*> chain;
  collectOpen(chain);
  try {
    const std::string fileName = name.value();
    std::string tried;
    const std::string path = findFile(fileName, name.source->directory, files.topDirectory, tried);
    if (path.empty()) {
      log.error(name.location(), what + ": no such file: " + name.shown(),
                "an existing file; tried " + tried);
      return nullptr;
    }
    if (++includes.count > IncludeCount::MAX_INCLUDES) {
      if (includes.count == IncludeCount::MAX_INCLUDES + 1)
        log.error(name.location(),
                  "more than " + std::to_string(IncludeCount::MAX_INCLUDES) + " files are included in all");
      return nullptr;
    }
    const Source& source = files.open(path);
    for (size_t i = 0; i < chain.size(); ++i) {
      if (chain[i]->canonical != source.canonical) continue;
      std::string names;
      for (size_t k = i; k < chain.size(); ++k) names += chain[k]->text->name + " includes ";
      log.error(name.location(), what + " would never end: " + names + source.text->name);
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
