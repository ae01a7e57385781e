/** @file
 * `recurse merge`: sum of renders of the same picture, which are kept in checkpoints.
 */
#include <filesystem>
#include <optional>

#include "apps/commands/commands.h"
#include "apps/options/developOptions.h"
#include "apps/options/optionText.h"
#include "apps/run/outputFiles.h"
#include "apps/run/renderOutput.h"
#include "recurse/core/io/atomicFile.h"
#include "recurse/render/checkpoint.h"

namespace recurse::apps {

namespace {

struct MergeOptions {
  std::vector<std::string> inputs, outputs;
  DevelopOptions develop;
  std::string checkpoint;
  ExtraLayers extra;
  bool partial = false, quiet = false;
};

std::string partsText(const Checkpoint& c) {
  std::string out;
  for (const Checkpoint::Part& p : c.parts)
    out += (out.empty() ? "" : "; ") + ("seed " + std::to_string(p.seed)) + ", samples " +
           std::to_string(p.first) + ":" + std::to_string(p.end);
  return out;
}

/** Sums the checkpoints. Without --partial a missing file is an Error, and so are missing samples if a
 * picture is written: a sum without a picture may be a part of a larger one. */
Checkpoint sumOf(const MergeOptions& o) {
  std::optional<Checkpoint> sum;
  std::string missing;
  const auto lacks = [&](const std::string& what) { missing += (missing.empty() ? "" : "\n  ") + what; };
  const bool mayLack = o.partial || o.outputs.empty();
  for (const std::string& input : o.inputs) {
    if (std::error_code ignored; !std::filesystem::exists(input, ignored)) {
      if (!o.partial && mayLack) throw Error(input + ": no such file");
      lacks(input + ": no such file");
      continue;
    }
    Checkpoint next = Checkpoint::read(input);
    if (next.allocation)
      if (const std::string rest = missingSamples(next); !rest.empty()) lacks(input + ": " + rest);
    if (sum)
      merge(*sum, next, input);
    else
      sum = std::move(next);
  }
  if (sum && !sum->allocation)
    if (const std::string rest = missingSamples(*sum); !rest.empty()) lacks(rest);
  if (!missing.empty() && !mayLack)
    throw Error("merge: samples are missing; add the files that have them, or make a picture of the others "
                "with --partial. Missing:\n"
                "  " +
                missing);
  if (!sum) throw Error("merge: none of the files exists");
  if (!missing.empty() && o.partial && !o.quiet) say("incomplete picture, missing:\n  " + missing + "\n");
  return std::move(*sum);
}

ExitStatus mergeRenders(const MergeOptions& o) {
  if (o.outputs.empty() && o.checkpoint.empty())
    throw Error("merge: no output; give -o FILE or --checkpoint FILE", ExitStatus::BAD_USAGE);
  PictureWriter writer(o.develop);
  for (const std::string& name : o.outputs) checkImageWritable(name);
  if (!o.checkpoint.empty()) checkFileWritable(o.checkpoint);
  std::vector<OutputFile> outputs = outputFiles("-o", o.outputs);
  outputs.push_back({"--checkpoint", o.checkpoint});
  requireDistinctFiles(outputs, inputFiles("an input checkpoint", o.inputs));

  Checkpoint sum = sumOf(o);
  const double samples = double(sum.film.totalSamples()) / double(sum.film.bounds().area());
  if (samples == 0) throw Error(o.inputs.front() + ": has no samples yet");
  std::string command = "recurse merge";
  for (const std::string& input : o.inputs) command += " " + shellQuoted(input);
  if (o.inputs.size() > 1) {
    sum.metadata["recurse:settings"] = command;
    sum.metadata["recurse:ended"] = "merged";
    sum.metadata.erase("recurse:seed");
    sum.metadata.erase("recurse:seconds");
  }
  sum.metadata["recurse:samples"] = formatted("%.9g", samples);
  sum.metadata["recurse:parts"] = partsText(sum);
  Image image = pictureOf(sum.film, sum.classes, sum.imagingRatio, o.extra);
  image.metadata = sum.metadata;
  std::string written;
  for (const std::string& name : o.outputs) {
    writer.write(name, image);
    written += (written.empty() ? "" : ", ") + name;
  }
  if (!o.checkpoint.empty()) {
    writeCheckpoint(o.checkpoint, sum);
    written += (written.empty() ? "" : ", ") + o.checkpoint;
  }
  if (!o.quiet)
    say(partsText(sum) + "\n" + formatted("%.6g", samples) + " samples per pixel\nwritten: " + written +
        "\n" + writer.remark());
  return ExitStatus::DONE;
}

} // namespace

void addMergeCommand(CLI::App& app, Command& chosen) {
  auto options = std::make_shared<MergeOptions>();
  MergeOptions& o = *options;
  CLI::App* command =
      app.add_subcommand("merge", "Add renders of the same picture with other seeds or other samples");
  command->add_option("checkpoints", o.inputs, "Files of 'recurse render --checkpoint'")
      ->required()
      ->type_name("FILE...");
  addRepeatedOption(*command, "-o,--output", o.outputs,
                    "Picture to write, may be repeated; formats of 'recurse render'")
      ->type_name("FILE");
  command->add_option("--checkpoint", o.checkpoint, "Write the sum as a checkpoint that can be merged again")
      ->type_name("FILE");
  o.develop.addTo(*command);
  command->add_flag("--error-layer", o.extra.error,
                    "Add the standard error of each pixel's luminance to .exr, as channel error.Y");
  command->add_flag("--samples-layer", o.extra.samples,
                    "Add the number of samples of each pixel to .exr, as channel samples.N");
  command->add_flag("--partial", o.partial, "Write a picture even if files or samples of --spp are missing");
  command->add_flag("-q,--quiet", o.quiet, "Print errors and warnings only");
  command->footer(
      "The renders must have the same scene files, integrator settings, size and samples per pixel, and no\n"
      "sample in common. The sum is bit-identical to one render of all samples.\n\n"
      "Examples:\n"
      "  recurse render scene.pbrt --spp 512 --sample-range 0:256 --checkpoint a.rck -o a.exr\n"
      "  recurse render scene.pbrt --spp 512 --sample-range 256:512 --checkpoint b.rck -o b.exr\n"
      "  recurse merge a.rck b.rck -o whole.exr -o whole.png\n"
      "  recurse merge unfinished.rck -o look.png --partial");
  command->callback([options, &chosen] { chosen = [options] { return mergeRenders(*options); }; });
}

} // namespace recurse::apps
