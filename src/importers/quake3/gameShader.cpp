/** @file
 * Reading of shader scripts. Line ends matter: the arguments of a directive end with its line.
 */
#include "importers/quake3/gameShader.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "recurse/core/io/text.h"
#include "recurse/core/io/zipArchive.h"

namespace recurse {

namespace {

struct Line {
  int number = 0;
  std::vector<std::string> words;
};

/** Words by lines, without comments; each brace is a separate word on a separate line. */
std::vector<Line> linesOf(const std::string& text) {
  std::vector<Line> lines;
  Line line{1, {}};
  int number = 1;
  const auto finish = [&] {
    if (!line.words.empty()) lines.push_back(line);
    line = {number, {}};
  };
  for (size_t i = 0; i < text.size();) {
    const char c = text[i];
    if (c == '\n') {
      ++number;
      ++i;
      finish();
    } else if (text.compare(i, 2, "//") == 0) {
      i = std::min(text.find('\n', i), text.size());
    } else if (text.compare(i, 2, "/*") == 0) {
      const size_t end = std::min(text.find("*/", i + 2), text.size() - 2) + 2;
      number += static_cast<int>(std::count(text.begin() + static_cast<std::ptrdiff_t>(i),
                                            text.begin() + static_cast<std::ptrdiff_t>(end), '\n'));
      i = end;
    } else if (c == '{' || c == '}') {
      finish();
      lines.push_back({number, {std::string(1, c)}});
      ++i;
    } else if (static_cast<unsigned char>(c) <= ' ') {
      ++i;
    } else if (c == '"') {
      const size_t end = std::min(text.find_first_of("\"\n", i + 1), text.size());
      line.words.push_back(text.substr(i + 1, end - i - 1));
      i = end < text.size() && text[end] == '"' ? end + 1 : end;
    } else {
      const size_t begin = i;
      while (i < text.size() && static_cast<unsigned char>(text[i]) > ' ' && text[i] != '{' && text[i] != '}')
        ++i;
      line.words.push_back(text.substr(begin, i - begin));
    }
  }
  ++number;
  finish();
  return lines;
}

class ScriptReader {
 public:
  ScriptReader(const std::string& name, std::vector<Line> lines, GameShaders& shaders,
               std::vector<std::string>& warnings)
      : fileName(name), lines(std::move(lines)), shaders(shaders), warnings(warnings) {}

  void read() {
    while (at < lines.size()) {
      const Line& title = lines[at++];
      if (title.words[0] == "{" || title.words[0] == "}") {
        warn(title, "a brace without a name before it");
        continue;
      }
      if (at == lines.size() || lines[at].words[0] != "{") {
        warn(title, "\"" + title.words[0] + "\" is not followed by a block");
        continue;
      }
      ++at;
      GameShader shader;
      readShader(shader, title);
      shaders.try_emplace(gameShaderName(title.words[0]), std::move(shader));
    }
  }

 private:
  void warn(const Line& line, const std::string& what) {
    warnings.push_back(fileName + ":" + std::to_string(line.number) + ": " + what);
  }

  static std::string word(const Line& line, size_t i) { return i < line.words.size() ? line.words[i] : ""; }

  double number(const Line& line, size_t i) {
    const std::string text = word(line, i);
    char* end = nullptr;
    const double value = std::strtod(text.c_str(), &end);
    if (!text.empty() && *end == '\0' && std::isfinite(value)) return value;
    warn(line, "\"" + line.words[0] + "\" has no number " + std::to_string(i));
    return 0;
  }

  void readShader(GameShader& shader, const Line& title) {
    while (at < lines.size()) {
      const Line& line = lines[at++];
      const std::string key = lowerCase(line.words[0]);
      if (key == "}") return;
      if (key == "{")
        readStage(shader.stages.emplace_back(), title);
      else
        readDirective(shader, line, key);
    }
    warn(title, "the block of \"" + title.words[0] + "\" has no end");
  }

  void readDirective(GameShader& shader, const Line& line, const std::string& key) {
    const std::string first = lowerCase(word(line, 1));
    if (key == "surfaceparm") {
      shader.isSky |= first == "sky";
      for (const char* name :
           {"nodraw", "hint", "skip", "areaportal", "playerclip", "monsterclip", "fog", "trigger"})
        shader.isInvisible |= first == name;
      shader.isLiquid |= first == "water" || first == "slime";
    } else if (key == "cull") {
      shader.isTwoSided |= first == "none" || first == "disable" || first == "twosided";
    } else if (key == "q3map_surfacelight") {
      shader.surfaceLight = std::max(number(line, 1), 0.0);
    } else if (key == "q3map_lightimage") {
      shader.lightImage = word(line, 1);
    } else if (key == "qer_editorimage") {
      shader.editorImage = word(line, 1);
    } else if (key == "skyparms") {
      shader.isSky = true;
      if (first != "-") shader.skyBox = word(line, 1);
    } else if (key == "q3map_sun" || key == "sun") {
      shader.sun = GameShader::Sun{{number(line, 1), number(line, 2), number(line, 3)},
                                   std::max(number(line, 4), 0.0),
                                   number(line, 5),
                                   number(line, 6)};
    }
  }

  void readStage(GameShader::Stage& stage, const Line& title) {
    while (at < lines.size()) {
      const Line& line = lines[at++];
      const std::string key = lowerCase(line.words[0]), first = lowerCase(word(line, 1));
      if (key == "}") return;
      if (key == "{") {
        warn(line, "a block within a stage");
        continue;
      }
      if (key == "map" || key == "clampmap") {
        stage.isLightmap = first == "$lightmap";
        if (!first.starts_with('$') && !first.starts_with('*')) stage.image = word(line, 1);
      } else if (key == "animmap") {
        stage.image = word(line, 2);
      } else if (key == "blendfunc") {
        stage.blendSource = first;
        stage.blendTarget = lowerCase(word(line, 2));
        if (first == "add") stage.blendSource = stage.blendTarget = "gl_one";
        if (first == "blend") stage.blendSource = "gl_src_alpha";
        if (first == "filter") stage.blendSource = "gl_dst_color";
      } else if (key == "alphafunc") {
        stage.alphaThreshold = first == "gt0" ? 1 / 255.0f : 128 / 255.0f;
        stage.showsLowAlpha = first == "lt128";
      } else if (key == "tcgen") {
        stage.isEnvironment = first == "environment";
      }
    }
    warn(title, "a stage of \"" + title.words[0] + "\" has no end");
  }

  std::string fileName;
  std::vector<Line> lines;
  size_t at = 0;
  GameShaders& shaders;
  std::vector<std::string>& warnings;
};

} // namespace

const GameShader::Stage* GameShader::base() const {
  for (const Stage& stage : stages) {
    if (stage.isLightmap || stage.isEnvironment || stage.image.empty()) continue;
    if (stage.isAdditive() && &stage != &stages.front()) continue;
    return &stage;
  }
  return nullptr;
}

std::string gameShaderName(const std::string& name) {
  std::string out = ZipArchive::normalised(name);
  const size_t dot = out.rfind('.');
  if (dot != std::string::npos && out.find('/', dot) == std::string::npos) out.resize(dot);
  return out;
}

void readGameShaders(const std::string& name, const std::string& text, GameShaders& shaders,
                     std::vector<std::string>& warnings) {
  ScriptReader(name, linesOf(text), shaders, warnings).read();
}

} // namespace recurse
