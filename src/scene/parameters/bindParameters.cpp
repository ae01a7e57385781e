/** @file
 * Checks of a file's parameters against the declarations of a plug-in.
 */
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "recurse/scene/parameters/parameters.h"
#include "recurse/scene/parameters/spectrum.h"
#include "scene/parameters/parameterParser.h"
#include "scene/parameters/parameterTypes.h"

namespace recurse {

using namespace sceneFile;

namespace {

std::string quoted(const std::string& s) { return "\"" + s + "\""; }

/** Checks one given parameter, and reports all its errors. */
class Checker {
 public:
  Checker(const ParameterSpec& spec, const ParsedParameter& value, Diagnostics& out)
      : spec(spec), value(value), out(out), minimum(spec.minimum), maximum(spec.maximum) {
    if (spec.type != ParameterType::SPECTRUM) return;
    if (!std::isfinite(minimum) && spec.spectrumKind != SpectrumKind::SIGNED) minimum = 0;
    if (spec.spectrumKind == SpectrumKind::ALBEDO && !std::isfinite(maximum)) maximum = 1;
  }

  bool good() {
    if (value.isBad) return false;
    if (!acceptsType(spec.type, spec.textured, value.type))
      return wrong(value.location,
                   "parameter " + quoted(spec.name) + " cannot be of type '" + value.type + "'",
                   declarationText(spec));
    if (value.type == "texture") return countIs(value.strings.size(), 1, "the name of one texture");
    if (spec.type == ParameterType::STRING)
      return countIs(value.strings.size(), size_t(spec.count), "string") && stringsAreChoices();
    if (spec.type == ParameterType::BOOLEAN)
      return countIs(value.booleans.size(), size_t(spec.count), "true or false");
    return spec.type == ParameterType::SPECTRUM ? spectrumIsGood()
                                                : numbersAreGood(traitsOf(spec.type).numbersEach);
  }

  double low() const { return minimum; }
  double high() const { return maximum; }

 private:
  bool wrong(const SourceLocation& where, const std::string& message, const std::string& accepted = {}) {
    out.error(where, message, accepted);
    return false;
  }

  bool countIs(size_t have, size_t want, const std::string& what) {
    const bool any = want == 0 && (have > 0 || spec.ignored);
    if (any || (want > 0 && have == want)) return true;
    return wrong(have ? value.valueLocation : value.location,
                 "parameter " + quoted(spec.name) + " has " + std::to_string(have) +
                     (have == 1 ? " value" : " values") + " instead of " +
                     (want ? std::to_string(want) : "at least one"),
                 what);
  }

  bool stringsAreChoices() {
    if (spec.choices.empty()) return true;
    for (const std::string& s : value.strings) {
      if (std::find(spec.choices.begin(), spec.choices.end(), s) != spec.choices.end()) continue;
      std::string message = "parameter " + quoted(spec.name) + " cannot be " + quoted(s);
      const auto near = nearestNames(s, spec.choices, 1);
      if (!near.empty()) message += "; did you mean " + quoted(near[0]) + "?";
      return wrong(value.valueLocation, message, rangeText(spec));
    }
    return true;
  }

  bool inRange(double x) const {
    return x >= minimum && x <= maximum && !(spec.minimumExcluded && x == minimum) && std::isfinite(x) &&
           !tooLarge(x);
  }
  /** True for numbers that overflow in single precision, in which plug-ins compute. */
  static bool tooLarge(double x) { return std::abs(x) > double(std::numeric_limits<float>::max()); }

  /** Location of the i-th number, found by parsing the list again. */
  SourceLocation placeOf(size_t i) const {
    const SourceLocation& start = value.valueLocation;
    if (i == 0 || !start.source || start.line < 1) return start;
    const std::string& text = start.source->text;
    size_t offset = 0;
    for (int line = 1; line < start.line && offset != std::string::npos; ++line) {
      offset = text.find('\n', offset);
      if (offset != std::string::npos) ++offset;
    }
    if (offset == std::string::npos) return start;
    Source source;
    source.text = start.source;
    Lexer lexer(source);
    try {
      lexer.moveTo(offset + static_cast<size_t>(start.column - 1), start.line, start.column);
      for (size_t k = 0;; ++k) {
        const Token token = lexer.next();
        // An Include among the values invalidates the count.
        if (!looksLikeNumber(token)) return start;
        if (k == i) return token.location();
      }
    } catch (const SceneError&) {
      return start;
    }
  }

  bool checkRange(const std::vector<double>& v, size_t first = 0, size_t step = 1) {
    for (size_t i = first; i < v.size(); i += step) {
      if (inRange(v[i])) continue;
      return wrong(placeOf(i),
                   "parameter " + quoted(spec.name) +
                       (!std::isfinite(v[i]) ? " is not finite"
                        : tooLarge(v[i])     ? " is too large for single precision"
                                             : " is out of range"),
                   rangeText(spec));
    }
    return true;
  }

  bool numbersAreGood(size_t each) {
    const auto& v = value.numbers;
    if (each > 1 && v.size() % each)
      return wrong(value.valueLocation, "parameter " + quoted(spec.name) + " has " +
                                            std::to_string(v.size()) +
                                            " numbers, which is not a multiple of " + std::to_string(each));
    if (!countIs(v.size() / each, size_t(spec.count), traitsOf(spec.type).description)) return false;
    if (spec.type == ParameterType::INTEGER)
      for (size_t i = 0; i < v.size(); ++i) {
        if (std::trunc(v[i]) != v[i])
          return wrong(placeOf(i), "parameter " + quoted(spec.name) + " must be a whole number");
        if (v[i] < std::numeric_limits<int>::min() || v[i] > std::numeric_limits<int>::max())
          return wrong(placeOf(i), "parameter " + quoted(spec.name) + " does not fit into 32 bits");
      }
    return checkRange(v);
  }

  bool spectrumIsGood() {
    const auto& v = value.numbers;
    if (value.type == "rgb" || value.type == "float") {
      const size_t each = value.type == "rgb" ? 3 : 1;
      if (v.size() % each)
        return wrong(value.valueLocation,
                     "the rgb parameter " + quoted(spec.name) + " has " + std::to_string(v.size()) +
                         " numbers",
                     "three numbers for a colour: red, green, blue");
      return countIs(v.size() / each, size_t(spec.count),
                     each == 3 ? "three numbers for a colour: red, green, blue" : "one number") &&
             checkRange(v);
    }
    if (value.type == "blackbody") {
      const bool isScaled = v.size() == 2 && spec.count == 1;
      if (isScaled && !(v[1] >= 0 && std::isfinite(v[1])))
        return wrong(placeOf(1), "the scale of the blackbody " + quoted(spec.name) + " must not be negative");
      if (isScaled)
        out.warning(value.valueLocation,
                    "blackbody " + quoted(spec.name) +
                        " has a temperature and a scale, as in pbrt-v3, and uses both; in pbrt-v4 write one "
                        "temperature in kelvin, and \"float scale\"");
      else if (!countIs(v.size(), size_t(spec.count), "one temperature in kelvin"))
        return false;
      const size_t temperatures = isScaled ? 1 : v.size();
      for (size_t i = 0; i < temperatures; ++i)
        if (!(v[i] > 0) || !std::isfinite(v[i]))
          return wrong(placeOf(i), "the temperature of " + quoted(spec.name) + " must be positive");
      // Components may be negative, unless a positive minimum protects divisions by the parameter.
      for (size_t i = 0; i < temperatures && minimum > 0; ++i) {
        const Rgbd c = rgbOfBlackbody(v[i], spec.spectrumKind) * (isScaled ? v[1] : 1.0);
        if (!inRange(c.r) || !inRange(c.g) || !inRange(c.b))
          return wrong(placeOf(i), "parameter " + quoted(spec.name) + " is out of range at this temperature",
                       rangeText(spec));
      }
      return true;
    }
    if (!value.strings.empty())
      return countIs(value.strings.size(), size_t(spec.count), "the name of a spectrum, or of a file");
    if (v.empty()) return countIs(0, 1, "pairs of wavelength in nm and value, or a name");
    try {
      spectrumFromPairs(v);
    } catch (const Error& e) {
      return wrong(value.valueLocation, "parameter " + quoted(spec.name) + ": " + e.what(),
                   "pairs of wavelength in nm and value");
    }
    return checkRange(v, 1, 2);
  }

  const ParameterSpec& spec;
  const ParsedParameter& value;
  Diagnostics& out;
  double minimum, maximum;
};

/** Type word of a default text; a word at its beginning may specify the type. */
std::string defaultTypeWord(const ParameterSpec& spec, std::string& text) {
  if (spec.type != ParameterType::SPECTRUM) return traitsOf(spec.type).word;
  for (const char* word : {"rgb ", "blackbody ", "spectrum ", "float "})
    if (text.rfind(word, 0) == 0) {
      text.erase(0, std::string(word).size());
      return std::string(word, std::string(word).size() - 1);
    }
  if (text.find_first_of("\"-") != std::string::npos && !looksLikeNumberText(text)) return "spectrum";
  size_t numbers = 0;
  bool inside = false;
  for (char c : text) {
    const bool blank = c == ' ' || c == '[' || c == ']';
    numbers += !blank && !inside;
    inside = !blank;
  }
  return numbers == 1 ? "float" : numbers == 3 ? "rgb" : "spectrum";
}

[[noreturn]] void badDefault(const ParameterSpec& spec, const std::string& why) {
  throw std::logic_error("the default of parameter \"" + spec.name + "\" is wrong: " + spec.defaultText +
                         ": " + why);
}

ParsedParameter parseDefault(const ParameterSpec& spec) {
  ParsedParameter p;
  p.name = spec.name;
  std::string text = spec.defaultText;
  p.type = defaultTypeWord(spec, text);
  const bool bareString = (spec.type == ParameterType::STRING || p.type == "spectrum") && text[0] != '"' &&
                          text[0] != '[' && !(p.type == "spectrum" && looksLikeNumberText(text));
  if (bareString) {
    p.strings = {text};
    return p;
  }
  // Direct use of the lexer, for speed: a scene may have a million shapes, each with its defaults.
  Source source;
  source.text = std::make_shared<const SourceText>(SourceText{"", text});
  Lexer lexer(source);
  try {
    for (;;) {
      const Token token = lexer.next();
      if (token.kind == TokenKind::END) break;
      if (token.kind == TokenKind::OPEN || token.kind == TokenKind::CLOSE) continue;
      if (token.kind == TokenKind::STRING)
        p.strings.push_back(token.value());
      else if (token.isWord("true") || token.isWord("false"))
        p.booleans.push_back(token.isWord("true"));
      else
        p.numbers.push_back(numberValue(token));
    }
  } catch (const SceneError& e) {
    badDefault(spec, e.what());
  }
  return p;
}

void reportUnknown(const ParsedParameter& p, const std::string& plugIn,
                   const std::vector<ParameterSpec>& specs, Diagnostics& out, bool lenient) {
  std::vector<std::string> names;
  std::string accepted;
  for (const ParameterSpec& s : specs) {
    names.push_back(s.name);
    accepted += (accepted.empty() ? "" : ", ") + declarationText(s);
  }
  std::string message = quoted(plugIn) + " has no parameter " + quoted(p.name);
  const auto near = nearestNames(p.name, names);
  for (size_t i = 0; i < near.size(); ++i) message += (i ? " or " : "; did you mean ") + quoted(near[i]);
  if (!near.empty()) message += "?";
  if (specs.empty()) accepted = "no parameters";
  lenient ? out.warning(p.location, message, accepted) : out.error(p.location, message, accepted);
}

} // namespace

Parameters bindParameters(const ParsedDirective& directive, const std::vector<ParameterSpec>& specs,
                          Diagnostics& diagnostics, bool lenient) {
  Parameters result;
  result.name = directive.type;
  result.place = directive.location;
  result.baseDirectory = directive.directory;
  result.topDirectory = directive.topDirectory;
  result.files = directive.files;

  // The last parameter of each name counts; attributes are used only for names that the directive omits.
  std::vector<const ParsedParameter*> given(specs.size(), nullptr);
  const auto slotOf = [&](const std::string& name) -> const ParsedParameter** {
    for (size_t i = 0; i < specs.size(); ++i)
      if (specs[i].name == name) return &given[i];
    return nullptr;
  };
  for (const ParsedParameter& p : directive.parameters) {
    const ParsedParameter** slot = slotOf(p.name);
    if (!slot) {
      reportUnknown(p, directive.type, specs, diagnostics, lenient);
      continue;
    }
    if (*slot)
      diagnostics.warning(p.location, "parameter " + quoted(p.name) + " is given twice; this one is used");
    *slot = &p;
  }
  if (directive.attributes)
    for (const ParsedParameter& p : *directive.attributes)
      if (const ParsedParameter** slot = slotOf(p.name); slot && !*slot) *slot = &p;

  result.bound.reserve(specs.size());
  for (size_t i = 0; i < specs.size(); ++i) {
    const ParameterSpec& spec = specs[i];
    Parameters::Bound b;
    b.name = spec.name;
    b.type = spec.type;
    b.kind = spec.spectrumKind;
    if (given[i]) {
      Checker checker(spec, *given[i], diagnostics);
      b.given = b.present = checker.good();
      b.minimum = checker.low();
      b.maximum = checker.high();
      if (b.present) b.value = *given[i];
    } else if (spec.required) {
      diagnostics.error(directive.location,
                        quoted(directive.type) + " needs the parameter " + quoted(spec.name),
                        declarationText(spec));
    }
    if (!b.present && !spec.defaultText.empty()) {
      b.value = parseDefault(spec);
      Diagnostics own;
      Checker checker(spec, b.value, own);
      if (!checker.good()) badDefault(spec, own.format());
      b.minimum = checker.low();
      b.maximum = checker.high();
      b.present = true;
    }
    result.bound.push_back(std::move(b));
  }
  return result;
}

} // namespace recurse
