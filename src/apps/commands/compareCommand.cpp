/** @file
 * `recurse compare`: error of a picture against a reference.
 */
#include <cstdio>

#include "apps/commands/commands.h"
#include "apps/options/optionText.h"
#include "apps/run/outputFiles.h"
#include "recurse/core/io/atomicFile.h"
#include "recurse/core/io/text.h"
#include "recurse/report/compare/compare.h"
#include "recurse/report/compare/flip.h"
#include "recurse/report/marking/marking.h"
#include "recurse/report/stills/stills.h"

namespace recurse::apps {

namespace {

struct CompareOptions {
  std::string picture, reference, second;
  std::vector<std::string> noiseFree, failAbove, failBelow;
  std::string output, map = "relative";
  bool json = false, classes = false;
};

struct Limit {
  std::string metric;
  double value = 0;
  bool above = true;
};

Limit parseLimit(const std::string& option, const std::string& text, bool above) {
  const size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0)
    throw Error(option + ": '" + text + "' is not METRIC=NUMBER, such as relmse=0.01", ExitStatus::BAD_USAGE);
  Limit limit{text.substr(0, equals), parseReal(option, text.substr(equals + 1)), above};
  const std::vector<std::string> names = metricNames();
  if (std::find(names.begin(), names.end(), limit.metric) == names.end()) {
    std::string message = option + ": no error measure '" + limit.metric + "'; there are:";
    for (const std::string& name : names) message += " " + name;
    throw Error(message, ExitStatus::BAD_USAGE);
  }
  return limit;
}

Image mapOf(const std::string& scale, const Image& image, const Image& reference,
            const Comparison& comparison) {
  if (scale == "flip") return flipMap(*comparison.flip);
  if (scale == "hdrflip") return flipMap(*comparison.hdrFlip);
  return errorMap(image, reference, scale == "signed" ? ErrorMap::SIGNED : ErrorMap::RELATIVE);
}

/** Marks an exercise by the class layers of stills. */
ExitStatus markFiles(const CompareOptions& o) {
  if (!o.second.empty() || !o.noiseFree.empty() || !o.failAbove.empty() || !o.failBelow.empty())
    throw Error("--classes needs one picture and one reference, and excludes --fail-above and --fail-below",
                ExitStatus::BAD_USAGE);
  if (!o.output.empty() && !lowerCase(o.output).ends_with(".html"))
    throw Error("-o " + o.output + ": with --classes the output is a page, such as marks.html",
                ExitStatus::BAD_USAGE);
  if (!o.output.empty()) checkFileWritable(o.output);
  requireDistinctFiles({{"-o", o.output}}, {{"the reference", stillsFile(o.reference)},
                                            {"the picture that is marked", stillsFile(o.picture)}});
  const Image picture = readImage(stillsFile(o.picture));
  const Stills reference = readStills(o.reference);
  const Marking marking = markExercise(picture, reference);
  print(o.json ? markingJson(marking) : markingText(marking));
  if (!o.output.empty()) writeFileAtomically(o.output, markingPage(marking, reference, o.picture));
  return ExitStatus::DONE;
}

ExitStatus compareFiles(const CompareOptions& o) {
  if (o.classes) return markFiles(o);
  std::vector<Limit> limits;
  for (const std::string& text : o.failAbove) limits.push_back(parseLimit("--fail-above", text, true));
  for (const std::string& text : o.failBelow) limits.push_back(parseLimit("--fail-below", text, false));
  if (!o.noiseFree.empty() && !o.second.empty())
    throw Error("--noise-free A B needs one picture and one reference", ExitStatus::BAD_USAGE);
  const bool noiseFree = !o.second.empty() || !o.noiseFree.empty();
  for (const Limit& limit : limits)
    if (limit.metric.ends_with("_noise_free") && !noiseFree)
      throw Error(limit.metric + " needs two independent references", ExitStatus::BAD_USAGE);
  if (!o.output.empty()) checkImageWritable(o.output);
  std::vector<std::string> references = o.noiseFree;
  references.insert(references.end(), {o.reference, o.second});
  std::vector<InputFile> inputs = inputFiles("a reference", references);
  inputs.push_back({"the picture that is compared", o.picture});
  requireDistinctFiles({{"-o", o.output}}, inputs);

  const Image image = readImage(stillsFile(o.picture));
  Image reference = readImage(stillsFile(o.reference));
  Comparison comparison;
  std::string against = o.reference;
  if (!o.second.empty()) {
    const Image second = readImage(stillsFile(o.second));
    comparison = compareImages(image, reference, second);
    addClasses(comparison, image, reference, &second);
    reference = meanImage(reference, second);
    against = "the mean of " + o.reference + " and " + o.second;
  } else if (!o.noiseFree.empty()) {
    const Image a = readImage(stillsFile(o.noiseFree[0])), b = readImage(stillsFile(o.noiseFree[1]));
    comparison = compareImages(image, a, b, &reference);
    addClasses(comparison, image, a, &b, &reference);
  } else {
    comparison = compareImages(image, reference);
    addClasses(comparison, image, reference);
  }

  addFlip(comparison, image, reference);
  print(o.json ? comparisonJson(comparison)
               : "x = " + o.picture + "\nr = " + against + "\n\n" + comparisonTable(comparison));
  if (!o.output.empty()) writeImage(o.output, mapOf(o.map, image, reference, comparison));

  std::string failures;
  const auto fail = [&failures](const std::string& why) {
    failures += (failures.empty() ? "" : "\nrecurse: ") + why;
  };
  if (comparison.pixels == 0) fail("no pixel can be compared: the reference is not finite anywhere");
  if (comparison.nonFinite > 0)
    fail(o.picture + ": " + std::to_string(comparison.nonFinite) +
         " pixels are not finite (NaN or infinite)");
  for (const Limit& limit : limits) {
    const double value = metricByName(comparison, limit.metric);
    // NaN fails both comparisons.
    const bool good = limit.above ? value <= limit.value : value >= limit.value;
    if (good) continue;
    const std::string definition = metricDefinition(limit.metric);
    fail(limit.metric + " is " + formatted("%.6g", value) + ", " + (limit.above ? "above " : "below ") +
         formatted("%.6g", limit.value) + (definition.empty() ? "" : " (" + definition + ")"));
  }
  if (!failures.empty()) throw Error(failures);
  return ExitStatus::DONE;
}

} // namespace

void addCompareCommand(CLI::App& app, Command& chosen) {
  auto options = std::make_shared<CompareOptions>();
  CompareOptions& o = *options;
  CLI::App* command = app.add_subcommand("compare", "Measure the error of a picture against a reference");
  command->add_option("picture", o.picture, "The picture, x, or a folder of 'recurse stills'")
      ->required()
      ->type_name("X");
  command
      ->add_option("reference", o.reference,
                   "The reference, r. With a second reference: a, and r is the mean of a and b")
      ->required()
      ->type_name("REFERENCE");
  command->add_option("second", o.second, "Second reference, b, with noise independent of the first")
      ->type_name("B");
  command
      ->add_option("--noise-free", o.noiseFree,
                   "Two independent references for errors without the noise of the references; REFERENCE is "
                   "then the r of the denominator")
      ->expected(2)
      ->type_name("A B");
  command->add_flag(
      "--json", o.json,
      "Print JSON: mse relmse relmse_trimmed mape smape psnr max mean_ratio ..., each over all channels "
      "and as NAME_rgb; flip hdrflip; relmse_at_8 after averaging 8x8 pixels; with two references "
      "mse_noise_free relmse_noise_free relmse_noise_free_at_8; of stills `classes`, each with name, "
      "expression, share and the errors by scale");
  command->add_flag("--classes", o.classes,
                    "Mark X as a student's exercise: find the path classes of REFERENCE, an EXR of 'recurse "
                    "stills', that are missing, counted twice or scaled, with region and certainty; also "
                    "wrong display encoding, exposure, flips and shifts. With --json: all numbers");
  command
      ->add_option("-o,--output", o.output,
                   "Write a false-colour picture of the error; with --classes a page, FILE.html, with a map "
                   "of the regions")
      ->type_name("FILE");
  command
      ->add_option("--map", o.map,
                   "Scale of the false colours (default: relative). relative: |x-r|/(|r|+0.01), logarithmic, "
                   "from 0.001 (dark violet) to 1 (yellow); signed: (x-r)/(|r|+0.01) from -0.5 (blue) to 0.5 "
                   "(red); flip and hdrflip: visible difference from 0 to 1")
      ->check(CLI::IsMember({"relative", "signed", "flip", "hdrflip"}))
      ->type_name("SCALE");
  addRepeatedOption(*command, "--fail-above", o.failAbove,
                    "Exit status 1 if the measure is larger than this; may be repeated")
      ->type_name("METRIC=NUMBER");
  addRepeatedOption(*command, "--fail-below", o.failBelow,
                    "Exit status 1 if the measure is smaller than this: for psnr and mean_ratio")
      ->type_name("METRIC=NUMBER");
  command->footer(
      "Examples:\n"
      "  recurse compare picture.exr reference.exr\n"
      "  recurse compare picture.exr reference.exr --json -o error.png\n"
      "  recurse compare picture.exr reference.exr -o seen.png --map hdrflip\n"
      "  recurse compare picture.exr a.exr b.exr\n"
      "  recurse compare picture.exr best.exr --noise-free a.exr b.exr\n"
      "  recurse compare picture.exr reference.exr --fail-above relmse=0.01 --fail-below mean_ratio=0.99\n"
      "  recurse compare picture.exr a.exr b.exr --fail-above relmse_noise_free_at_8=0.001\n"
      "  recurse compare stills/stills.exr reference/stills.exr\n"
      "  recurse compare student.exr stills/stills.exr --classes -o marks.html\n\n"
      "With two references whose noise is independent, the error mean((x-a)(x-b)/(r^2+0.01)) is free of\n"
      "that noise; r is their mean, or REFERENCE with --noise-free. FLIP measures the visible difference\n"
      "of alternating pictures, on a display 0.7 m and 3840 pixels wide at a distance of 0.7 m. Pixels\n"
      "where a reference is not finite are left out and counted; pixels of X that are not finite give exit\n"
      "status 1. If both are EXR files of 'recurse stills' with the same path classes, the errors of each\n"
      "class are printed, too.");
  command->callback([options, &chosen] { chosen = [options] { return compareFiles(*options); }; });
}

} // namespace recurse::apps
