/** @file
 * Stills: the classes to render, their figures, and the files.
 */
#include "recurse/report/stills/stills.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>
#include <sstream>
#include <string_view>

#include "recurse/core/io/atomicFile.h"
#include "recurse/core/io/error.h"
#include "recurse/core/io/text.h"
#include "recurse/pathclasses/classesReport.h"
#include "recurse/pathclasses/pathEvent.h"
#include "recurse/pathclasses/pathNames.h"

namespace recurse {

namespace fs = std::filesystem;

namespace {

constexpr size_t LONGEST_NAME = 60;

[[noreturn]] void badUsage(const std::string& message) { throw Error(message, ExitStatus::BAD_USAGE); }

bool isLetterOrDigit(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
}

/** Checks names of classes, which name channels and files, also on case-insensitive file systems. */
void checkNames(const std::vector<PathClass>& classes) {
  std::set<std::string> names = {"beauty"};
  for (const PathClass& c : classes) {
    const bool plain = std::all_of(c.name.begin(), c.name.end(),
                                   [](char x) { return isLetterOrDigit(x) || x == '-' || x == '_'; });
    if (c.name.empty() || !plain || !isLetterOrDigit(c.name[0]) || c.name.size() > LONGEST_NAME)
      badUsage("'" + c.name + "' cannot be the name of a class: use up to " + std::to_string(LONGEST_NAME) +
               " letters a-z, digits, '-' and '_', beginning with a letter or digit");
    if (c.name == "beauty") badUsage("'beauty' is the whole picture and cannot be the name of a class");
    if (!names.insert(lowerCase(c.name)).second) badUsage("two classes are named '" + c.name + "'");
  }
}

std::string freeName(const std::vector<PathClass>& classes, std::string name) {
  const auto taken = [&] {
    return std::any_of(classes.begin(), classes.end(),
                       [&](const PathClass& c) { return lowerCase(c.name) == name; });
  };
  while (taken()) name += "_";
  return name;
}

std::string restExpression(const PathAutomaton& rest, const std::vector<PathClass>& classes) {
  if (const std::string shortest = rest.toExpression(40); !shortest.empty()) return shortest;
  std::string others;
  for (const PathClass& c : classes) others += (others.empty() ? "(" : "|(") + c.expression + ")";
  return "all - (" + others + ")";
}

/** Linear value of an encoded one above the linear segment of sRGB (IEC 61966-2-1). */
double linearFromSrgb(double x) { return std::pow((x + 0.055) / 1.055, 2.4); }

void measure(Stills& stills) {
  const Image& image = stills.image;
  const size_t stride = image.channels.size(), pixels = image.pixels.size() / stride;
  std::vector<Rgbd> means;
  for (size_t i = 0; i < stills.layers.size(); ++i) {
    Rgbd sum{0};
    for (size_t p = 0; p < pixels; ++p)
      for (size_t c = 0; c < 3; ++c) sum[int(c)] += double(image.pixels[p * stride + i * 3 + c]);
    means.push_back(sum / double(pixels));
  }
  const double whole = luminance(means.front());
  for (size_t i = 0; i < stills.layers.size(); ++i) {
    StillLayer& layer = stills.layers[i];
    layer.mean = Rgb(means[i]);
    layer.share = whole != 0 ? luminance(means[i]) / whole : 0;
    layer.exposure = automaticExposure(stills.layerImage(i));
  }
}

std::vector<std::string> channelNames(const std::vector<StillLayer>& layers) {
  std::vector<std::string> names;
  for (size_t i = 0; i < layers.size(); ++i)
    for (const char* c : {"R", "G", "B"}) names.push_back(i == 0 ? c : layers[i].name + "." + c);
  return names;
}

constexpr std::string_view SEPARATOR = "; "; ///< of classes in metadata

/** Classes of a list in metadata. Names in quotes may contain the separator. */
std::vector<std::string> listedClasses(const std::string& text) {
  std::vector<std::string> out;
  for (size_t i = 0, begin = 0; begin < text.size(); ++i) {
    if (i < text.size() && text[i] == '\'') i = std::min(text.find('\'', i + 1), text.size());
    if (i < text.size() && text.compare(i, SEPARATOR.size(), SEPARATOR) != 0) continue;
    out.push_back(text.substr(begin, i - begin));
    begin = i + SEPARATOR.size();
  }
  return out;
}

/** Remarks in metadata, one a line. */
std::vector<std::string> listedRemarks(const std::string& text) {
  std::vector<std::string> out;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) out.push_back(line);
  return out;
}

} // namespace

StillsPlan planStills(const std::vector<PathClass>& asked, const PathNames* names) {
  if (asked.empty()) badUsage("no path class is given");
  checkNames(asked);
  StillsPlan plan;
  plan.classes = asked;
  for (const PathClass& c : asked) {
    try {
      PathAutomaton::compile(c.expression, PathAutomaton::Empty::REFUSED, names);
    } catch (const Error& error) {
      badUsage("class " + c.name + ": " + error.what());
    }
  }
  const std::vector<PathAutomaton> automata =
      PathAutomaton::compileAll(asked, PathAutomaton::Empty::REFUSED, names);
  const PathAutomaton all = PathAutomaton::compile("all");
  const std::vector<PathOverlap> overlaps = findOverlaps(automata);
  for (const PathOverlap& o : overlaps)
    plan.remarks.push_back(asked[o.first].name + " and " + asked[o.second].name + " overlap: both contain " +
                           o.example);
  const PathAutomaton rest = leftOver(all, automata);
  if (!rest.isEmpty()) {
    const PathClass added{freeName(plan.classes, "rest"), restExpression(rest, asked)};
    plan.remarks.push_back("the classes do not contain all paths, such as " + rest.shortestWord() +
                           ": these paths are in the class " + added.name + ", which was added");
    plan.classes.push_back(added);
  }
  plan.shown = plan.classes.size();
  if (!overlaps.empty()) {
    plan.remarks.push_back("the classes overlap, so that their sum is not the whole picture");
    const auto whole =
        std::find_if(automata.begin(), automata.end(), [&](const auto& a) { return a.equivalent(all); });
    if (whole == automata.end()) plan.classes.push_back({freeName(plan.classes, "all"), "all"});
    plan.beauty = static_cast<int>(whole == automata.end() ? plan.classes.size() - 1
                                                           : size_t(whole - automata.begin()));
  }
  return plan;
}

Image Stills::layerImage(size_t layer) const {
  Image out(image.width, image.height, {"R", "G", "B"});
  const size_t stride = image.channels.size(), pixels = image.pixels.size() / stride;
  for (size_t p = 0; p < pixels; ++p)
    std::copy_n(&image.pixels[p * stride + layer * 3], 3, &out.pixels[p * 3]);
  return out;
}

Stills makeStills(const Film& film, const StillsPlan& plan, float scale) {
  Stills stills;
  stills.additive = plan.additive();
  stills.remarks = plan.remarks;
  stills.layers.push_back({"beauty", "all"});
  for (size_t i = 0; i < plan.shown; ++i)
    stills.layers.push_back({plan.classes[i].name, plan.classes[i].expression});
  stills.image = Image(film.bounds().width(), film.bounds().height(), channelNames(stills.layers));
  const size_t stride = stills.image.channels.size();
  for (size_t pixel = 0; pixel < film.bounds().area(); ++pixel) {
    float* out = &stills.image.pixels[pixel * stride];
    Rgbd sum{0};
    const auto put = [&](size_t layer, const Rgb& value) {
      for (size_t c = 0; c < 3; ++c) out[layer * 3 + c] = value[int(c)];
    };
    for (size_t i = 0; i < plan.shown; ++i) {
      const Rgb value = film.value(pixel, i) * scale;
      sum += Rgbd(value);
      put(i + 1, value);
    }
    put(0, plan.additive() ? Rgb(sum) : film.value(pixel, size_t(plan.beauty)) * scale);
  }
  measure(stills);
  return stills;
}

void describeStills(Stills& stills) {
  std::string classes, remarks;
  for (size_t i = 1; i < stills.layers.size(); ++i) {
    if (i > 1) classes += SEPARATOR;
    classes += stills.layers[i].name + " = " + stills.layers[i].expression;
  }
  for (const std::string& remark : stills.remarks) remarks += (remarks.empty() ? "" : "\n") + remark;
  stills.image.metadata["recurse:classes"] = classes;
  stills.image.metadata["recurse:additive"] = stills.additive ? "yes" : "no";
  stills.image.metadata["recurse:remarks"] = remarks;
  stills.image.metadata["recurse:title"] = stills.title;
  stills.image.metadata["recurse:label"] = stills.label;
}

std::string stillsFile(const std::string& folderOrFile) {
  std::error_code ignored;
  return fs::is_directory(folderOrFile, ignored) ? (fs::path(folderOrFile) / "stills.exr").string()
                                                 : folderOrFile;
}

Stills stillsOf(const Image& picture, const std::string& fileName) {
  const auto metadata = [&](const std::string& name, const std::string& otherwise = {}) {
    const auto found = picture.metadata.find(name);
    return found == picture.metadata.end() ? otherwise : found->second;
  };
  Stills stills;
  stills.layers.push_back({"beauty", "all"});
  for (const std::string& text : listedClasses(metadata("recurse:classes"))) {
    const size_t equals = text.find(" = ");
    const std::string name = text.substr(0, equals);
    if (picture.channel(name + ".R") >= 0)
      stills.layers.push_back({name, equals == std::string::npos ? name : text.substr(equals + 3)});
  }
  // Layers of pictures by other programs have names only.
  for (const std::string& channel : picture.channels) {
    const std::string name = channel.ends_with(".R") ? channel.substr(0, channel.size() - 2) : "";
    const auto known = [&](const StillLayer& layer) { return layer.name == name; };
    const bool isColour = picture.channel(name + ".G") >= 0 && picture.channel(name + ".B") >= 0;
    if (!name.empty() && isColour && std::none_of(stills.layers.begin(), stills.layers.end(), known))
      stills.layers.push_back({name, ""});
  }
  stills.image = Image(picture.width, picture.height, channelNames(stills.layers));
  stills.image.metadata = picture.metadata;
  const size_t stride = stills.image.channels.size();
  for (size_t c = 0; c < stride; ++c) {
    const int from = picture.channel(stills.image.channels[c]);
    if (from < 0) throw Error(fileName + ": has no channel " + stills.image.channels[c]);
    const size_t pixels = size_t(picture.width) * size_t(picture.height);
    for (size_t p = 0; p < pixels; ++p)
      stills.image.pixels[p * stride + c] = picture.pixels[p * picture.channels.size() + size_t(from)];
  }
  stills.additive = metadata("recurse:additive") == "yes";
  stills.remarks = listedRemarks(metadata("recurse:remarks"));
  stills.title = metadata("recurse:title", fs::path(fileName).filename().string());
  stills.label = metadata("recurse:label", fileName);
  measure(stills);
  return stills;
}

Stills readStills(const std::string& folderOrFile) {
  const std::string fileName = stillsFile(folderOrFile);
  return stillsOf(readImage(fileName), fileName);
}

float automaticExposure(const Image& image) {
  std::vector<float> lights;
  const size_t stride = image.channels.size();
  for (size_t i = 0; i + 2 < image.pixels.size(); i += stride) {
    const float y = luminance(Rgb(image.pixels[i], image.pixels[i + 1], image.pixels[i + 2]));
    if (y > 0 && std::isfinite(y)) lights.push_back(y);
  }
  if (lights.empty()) return 0;
  const auto at = lights.begin() + static_cast<std::ptrdiff_t>(double(lights.size() - 1) * 0.98);
  std::nth_element(lights.begin(), at, lights.end());
  return static_cast<float>(std::log2(linearFromSrgb(double(STILLS_DISPLAY_WHITE)) / double(*at)));
}

std::string stillsTable(const Stills& stills) {
  size_t nameWidth = 0, expressionWidth = 0;
  constexpr size_t WIDEST = 48;
  for (const StillLayer& layer : stills.layers) {
    nameWidth = std::max(nameWidth, layer.name.size());
    expressionWidth = std::max(expressionWidth, std::min(layer.expression.size(), WIDEST));
  }
  std::string out;
  for (const StillLayer& layer : stills.layers) {
    std::string expression = layer.expression;
    if (expression.size() > WIDEST) expression = expression.substr(0, WIDEST - 3) + "...";
    out += formatted("%-*s  %-*s  %7.2f %%   mean %.4g %.4g %.4g   exposure %+.2f\n",
                     static_cast<int>(nameWidth), layer.name.c_str(), static_cast<int>(expressionWidth),
                     expression.c_str(), layer.share * 100, double(layer.mean.r), double(layer.mean.g),
                     double(layer.mean.b), double(layer.exposure));
  }
  for (const std::string& remark : stills.remarks) out += "note: " + remark + "\n";
  return out;
}

void checkStillsWritable(const std::string& folder) {
  for (const fs::path& path : {fs::path(folder), fs::path(folder) / "common", fs::path(folder) / "own"}) {
    std::error_code error;
    fs::create_directories(path, error);
    if (error || !fs::is_directory(path, error))
      throw Error(path.string() + ": the folder cannot be created: " +
                  (error ? error.message() : std::string("a file has this name")));
    checkFileWritable((path / "index.html").string());
  }
}

std::vector<std::string> writeStills(const std::string& folder, const Stills& stills, const Stills* other) {
  checkStillsWritable(folder);
  std::vector<std::string> written;
  const auto name = [&](const fs::path& file) {
    written.push_back((fs::path(folder) / file).string());
    return written.back();
  };
  writeImage(name("stills.exr"), stills.image);
  for (size_t i = 0; i < stills.layers.size(); ++i) {
    const Image layer = stills.layerImage(i);
    const std::string file = stills.layers[i].name + ".png";
    writeImage(name(fs::path("common") / file), layer, {.exposure = stills.commonExposure()});
    writeImage(name(fs::path("own") / file), layer, {.exposure = stills.layers[i].exposure});
  }
  writeImage(name("sheet.png"), contactSheet(stills));
  writeFileAtomically(name("index.html"), stillsPage(stills, other));
  return written;
}

} // namespace recurse
