/** @file
 * Declarations of parameters, and access to their checked values.
 */
#include "recurse/scene/parameters/parameters.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "recurse/core/io/text.h"
#include "recurse/scene/parameters/spectrum.h"
#include "scene/parameters/parameterTypes.h"
#include "scene/text/sourceFiles.h"

namespace recurse {

using sceneFile::traitsOf;

std::string declarationText(const ParameterSpec& spec) {
  std::string words =
      spec.type == ParameterType::SPECTRUM ? "rgb|spectrum|blackbody|float" : traitsOf(spec.type).word;
  if (spec.textured) words += "|texture";
  return "\"" + words + " " + spec.name + "\"";
}

std::string rangeText(const ParameterSpec& spec) {
  std::string out;
  const auto add = [&](const std::string& text) { out += (out.empty() ? "" : ", ") + text; };
  if (!spec.choices.empty()) {
    std::string choices;
    for (const std::string& c : spec.choices) choices += (choices.empty() ? "\"" : " \"") + c + "\"";
    add(choices);
  }
  double low = spec.minimum, high = spec.maximum;
  if (spec.type == ParameterType::SPECTRUM) {
    if (!std::isfinite(low) && spec.spectrumKind != SpectrumKind::SIGNED) low = 0;
    if (spec.spectrumKind == SpectrumKind::ALBEDO && !std::isfinite(high)) high = 1;
  }
  if (std::isfinite(low) && std::isfinite(high))
    add((spec.minimumExcluded ? "more than " : "") + formatted("%.10g", low) + " to " +
        formatted("%.10g", high));
  else if (std::isfinite(low))
    add((spec.minimumExcluded ? "more than " : "at least ") + formatted("%.10g", low));
  else if (std::isfinite(high))
    add("at most " + formatted("%.10g", high));
  if (spec.ignored) return out;
  if (spec.count == 0) add("any number of values");
  if (spec.count > 1) add(std::to_string(spec.count) + " values");
  return out;
}

namespace {

ParameterSpec makeSpec(ParameterType type, const std::string& name, const std::string& defaultText,
                       const std::string& description) {
  ParameterSpec spec;
  spec.type = type;
  spec.name = name;
  spec.defaultText = defaultText;
  spec.description = description;
  return spec;
}

} // namespace

ParameterSpec realParameter(const std::string& name, const std::string& defaultText,
                            const std::string& description) {
  return makeSpec(ParameterType::REAL, name, defaultText, description);
}
ParameterSpec integerParameter(const std::string& name, const std::string& defaultText,
                               const std::string& description) {
  return makeSpec(ParameterType::INTEGER, name, defaultText, description);
}
ParameterSpec booleanParameter(const std::string& name, const std::string& defaultText,
                               const std::string& description) {
  return makeSpec(ParameterType::BOOLEAN, name, defaultText, description);
}
ParameterSpec stringParameter(const std::string& name, const std::string& defaultText,
                              const std::string& description) {
  return makeSpec(ParameterType::STRING, name, defaultText, description);
}
ParameterSpec spectrumParameter(const std::string& name, const std::string& defaultText, SpectrumKind kind,
                                const std::string& description) {
  ParameterSpec spec = makeSpec(ParameterType::SPECTRUM, name, defaultText, description);
  spec.spectrumKind = kind;
  return spec;
}
ParameterSpec arrayParameter(ParameterType type, const std::string& name, int count,
                             const std::string& defaultText, const std::string& description) {
  ParameterSpec spec = makeSpec(type, name, defaultText, description);
  spec.count = count;
  return spec;
}
ParameterSpec ignoredParameter(ParameterType type, const std::string& name, const std::string& why) {
  ParameterSpec spec = makeSpec(type, name, "", why);
  spec.ignored = true;
  spec.count = 0;
  return spec;
}

const Parameters::Bound& Parameters::find(const std::string& wanted) const {
  for (const Bound& b : bound)
    if (b.name == wanted) return b;
  throw std::logic_error("plug-in \"" + name + "\" reads the parameter \"" + wanted +
                         "\" without declaring it");
}

const Parameters::Bound& Parameters::valueOf(const std::string& wanted,
                                             std::initializer_list<ParameterType> types) const {
  const Bound& b = find(wanted);
  if (std::find(types.begin(), types.end(), b.type) == types.end())
    throw std::logic_error("plug-in \"" + name + "\" reads the parameter \"" + wanted +
                           "\" as another type than it declares");
  if (!b.present)
    fail(wanted, "parameter \"" + wanted + "\" is missing",
         std::string("\"") + traitsOf(b.type).word + " " + wanted + "\"");
  if (b.value.type == "texture") fail(wanted, "parameter \"" + wanted + "\" cannot be a texture here");
  return b;
}

const Parameters::Bound& Parameters::oneValueOf(const std::string& wanted,
                                                std::initializer_list<ParameterType> types) const {
  const Bound& b = valueOf(wanted, types);
  const size_t each = traitsOf(b.type).numbersEach;
  const size_t have =
      each ? b.value.numbers.size() / each : std::max(b.value.strings.size(), b.value.booleans.size());
  if (have == 0) fail(wanted, "parameter \"" + wanted + "\" has no value");
  return b;
}

bool Parameters::has(const std::string& wanted) const { return find(wanted).given; }
bool Parameters::hasValue(const std::string& wanted) const { return find(wanted).present; }

bool Parameters::boolean(const std::string& wanted) const {
  return oneValueOf(wanted, {ParameterType::BOOLEAN}).value.booleans[0];
}

int Parameters::integer(const std::string& wanted) const {
  return static_cast<int>(oneValueOf(wanted, {ParameterType::INTEGER}).value.numbers[0]);
}

double Parameters::real(const std::string& wanted) const {
  return oneValueOf(wanted, {ParameterType::REAL, ParameterType::INTEGER}).value.numbers[0];
}

std::string Parameters::string(const std::string& wanted) const {
  return oneValueOf(wanted, {ParameterType::STRING}).value.strings[0];
}

Vec3d Parameters::vector3(const std::string& wanted) const {
  const auto& v = oneValueOf(wanted, {ParameterType::POINT3, ParameterType::VECTOR3, ParameterType::NORMAL})
                      .value.numbers;
  return {v[0], v[1], v[2]};
}

std::vector<int> Parameters::integers(const std::string& wanted) const {
  const auto& v = valueOf(wanted, {ParameterType::INTEGER}).value.numbers;
  std::vector<int> out(v.size());
  std::transform(v.begin(), v.end(), out.begin(), [](double x) { return static_cast<int>(x); });
  return out;
}

std::vector<double> Parameters::reals(const std::string& wanted) const {
  return valueOf(wanted, {ParameterType::REAL, ParameterType::INTEGER}).value.numbers;
}

std::vector<Vec2d> Parameters::vector2s(const std::string& wanted) const {
  const auto& v = valueOf(wanted, {ParameterType::POINT2, ParameterType::VECTOR2}).value.numbers;
  std::vector<Vec2d> out(v.size() / 2);
  for (size_t i = 0; i < out.size(); ++i) out[i] = {v[2 * i], v[2 * i + 1]};
  return out;
}

std::vector<Vec3d> Parameters::vector3s(const std::string& wanted) const {
  const auto& v =
      valueOf(wanted, {ParameterType::POINT3, ParameterType::VECTOR3, ParameterType::NORMAL}).value.numbers;
  std::vector<Vec3d> out(v.size() / 3);
  for (size_t i = 0; i < out.size(); ++i) out[i] = {v[3 * i], v[3 * i + 1], v[3 * i + 2]};
  return out;
}

std::vector<std::string> Parameters::strings(const std::string& wanted) const {
  return valueOf(wanted, {ParameterType::STRING}).value.strings;
}

Rgbd Parameters::spectrumOf(const Bound& b, const ParsedParameter& v) const {
  const auto checked = [&](const std::vector<double>& values) {
    for (double x : values)
      if (x < b.minimum || x > b.maximum)
        fail(b.name, "the spectrum of parameter \"" + b.name + "\" is out of range");
  };
  if (v.type == "float") return Rgbd(v.numbers[0]);
  if (v.type == "rgb") return {v.numbers[0], v.numbers[1], v.numbers[2]};
  if (v.type == "blackbody")
    return rgbOfBlackbody(v.numbers[0], b.kind) * (v.numbers.size() == 2 ? v.numbers[1] : 1.0);
  if (v.strings.empty()) {
    const SampledSpectrum spectrum = spectrumFromPairs(v.numbers); // checked by bindParameters()
    checked(spectrum.values);
    return rgbOfSpectrum(spectrum, b.kind);
  }
  const std::string& spectrumName = v.strings[0];
  if (const auto rgb = rgbOfNamedSpectrum(spectrumName)) {
    checked({rgb->r, rgb->g, rgb->b});
    return *rgb;
  }
  std::string tried;
  const std::string path = sceneFile::findFile(
      spectrumName, v.directory.empty() ? baseDirectory : v.directory, topDirectory, tried);
  if (path.empty()) {
    std::string message = "\"" + spectrumName + "\" is neither a known spectrum nor a file";
    const auto near = nearestNames(spectrumName, namedSpectra(), 1);
    if (!near.empty()) message += "; did you mean \"" + near[0] + "\"?";
    std::string accepted = "a file (tried " + tried + ") or one of";
    for (const std::string& known : namedSpectra()) accepted += " " + known;
    fail(b.name, message, accepted);
  }
  try {
    const SampledSpectrum spectrum = readSpectrumFile(path);
    checked(spectrum.values);
    return rgbOfSpectrum(spectrum, b.kind);
  } catch (const SceneError&) {
    throw;
  } catch (const Error& e) {
    fail(b.name, e.what());
  }
}

Rgbd Parameters::spectrum(const std::string& wanted) const {
  const Bound& b = valueOf(wanted, {ParameterType::SPECTRUM});
  return spectrumOf(b, b.value);
}

SampledSpectrum Parameters::sampledSpectrum(const std::string& wanted) const {
  const Bound& b = valueOf(wanted, {ParameterType::SPECTRUM});
  const ParsedParameter& v = b.value;
  if (v.type != "spectrum") return {};
  if (v.strings.empty()) return spectrumFromPairs(v.numbers);
  if (const auto glass = indexOfNamedGlass(v.strings[0])) return *glass;
  if (rgbOfNamedSpectrum(v.strings[0])) return {};
  spectrumOf(b, v); // throws where the file does not exist
  std::string tried;
  return readSpectrumFile(sceneFile::findFile(v.strings[0], v.directory.empty() ? baseDirectory : v.directory,
                                              topDirectory, tried));
}

std::vector<Rgbd> Parameters::spectra(const std::string& wanted) const {
  const Bound& b = valueOf(wanted, {ParameterType::SPECTRUM});
  const auto& v = b.value.numbers;
  std::vector<Rgbd> out;
  if (b.value.type == "rgb") {
    for (size_t i = 0; i + 2 < v.size(); i += 3) out.emplace_back(v[i], v[i + 1], v[i + 2]);
  } else if (b.value.type == "float") {
    for (double x : v) out.emplace_back(x);
  } else if (b.value.type == "blackbody") {
    for (double x : v) out.push_back(rgbOfBlackbody(x, b.kind));
  } else if (b.value.strings.empty()) {
    out.push_back(spectrumOf(b, b.value));
  } else {
    ParsedParameter one = b.value;
    for (const std::string& s : b.value.strings) {
      one.strings = {s};
      out.push_back(spectrumOf(b, one));
    }
  }
  return out;
}

std::string Parameters::texture(const std::string& wanted) const {
  const Bound& b = find(wanted);
  return b.present && b.value.type == "texture" ? b.value.strings[0] : std::string();
}

std::pair<double, double> Parameters::range(const std::string& wanted) const {
  const Bound& b = find(wanted);
  return {b.minimum, b.maximum};
}

std::string Parameters::filePath(const std::string& wanted) const {
  const Bound& b = oneValueOf(wanted, {ParameterType::STRING});
  std::string tried;
  const std::string path = sceneFile::findFile(
      b.value.strings[0], b.value.directory.empty() ? baseDirectory : b.value.directory, topDirectory, tried);
  if (path.empty())
    fail(wanted, "there is no file \"" + b.value.strings[0] + "\"", "an existing file; tried " + tried);
  return path;
}

FileReference Parameters::file(const std::string& wanted) const {
  const Bound& b = oneValueOf(wanted, {ParameterType::STRING});
  if (files)
    if (const auto found = files->find(b.value.strings[0]); found != files->end())
      return {found->first, found->second};
  return filePath(wanted);
}

SourceLocation Parameters::location(const std::string& wanted) const {
  const Bound& b = find(wanted);
  return b.given ? b.value.valueLocation : place;
}

void Parameters::fail(const std::string& wanted, const std::string& message,
                      const std::string& accepted) const {
  throw SceneError(wanted.empty() ? place : location(wanted), message, accepted);
}

void Parameters::warn(const std::string& wanted, const std::string& message,
                      const std::string& accepted) const {
  told->warning(wanted.empty() ? place : location(wanted), message, accepted);
}

} // namespace recurse
