/** @file
 * `recurse develop`: pictures for a display from a picture with unbounded linear values.
 */
#include <filesystem>

#include "apps/animation/animationFiles.h"
#include "apps/commands/commands.h"
#include "apps/options/developOptions.h"
#include "apps/options/optionText.h"
#include "apps/run/outputFiles.h"
#include "recurse/core/io/atomicFile.h"
#include "recurse/core/io/text.h"

namespace recurse::apps {

namespace {

struct DevelopCommandOptions {
  std::string input;
  std::vector<std::string> outputs;
  DevelopOptions develop;
  std::string frameRate = "24";
  bool sheet = false, quiet = false;
};

bool isPage(const std::string& name) { return lowerCase(name).ends_with(".html"); }

void checkOutputs(const DevelopCommandOptions& o) {
  for (const std::string& name : o.outputs) {
    if (isPage(name))
      checkFileWritable(name);
    else if (isAnimationFormat(name))
      checkAnimationOutput(name, o.develop);
    else
      checkImageWritable(name);
    if (!isPage(name) && !isAnimationFormat(name) && !isDisplayFormat(name))
      badUsage(
          "-o: " + name +
          " is not a picture format for displays; accepted: .png .jpg .jpeg .tif .tiff .html, for a film "
          ".apng .mp4");
    if (isPage(name) && o.develop.toneMap.find(' ') != std::string::npos)
      badUsage("--tonemap: a page has all operators with their defaults; remove --tonemap");
    if (isPage(name) && o.sheet) badUsage("--sheet: not together with the page " + name);
  }
}

ExitStatus developPicture(const DevelopCommandOptions& o) {
  const DevelopSettings settings = o.develop.settings();
  const double frameRate = parseFrameRate(o.frameRate);
  checkOutputs(o);
  requireDistinctFiles(outputFiles("-o", o.outputs), {{"the input picture", o.input}});
  const Image picture = readImage(o.input);
  Developed developed = o.sheet ? operatorSheet(picture, settings) : develop(picture, settings);
  developed.picture.metadata["recurse:developed"] = o.develop.text(developed.stops);
  std::string written, ofFilm;
  for (const std::string& name : o.outputs) {
    if (isPage(name))
      writeFileAtomically(name,
                          developPage(picture, settings, std::filesystem::path(o.input).filename().string(),
                                      o.develop.toneMap));
    else if (isAnimationFormat(name))
      ofFilm = formatted("; of the film %+.2f stops",
                         writeTransientAnimation(name, picture, o.develop, frameRate));
    else
      writeImage(name, developed.picture, {.encoded = true});
    written += (written.empty() ? "" : ", ") + name;
  }
  if (!o.quiet)
    say(formatted("exposure %+.2f stops", developed.stops) + ofFilm + ", tone operator " +
        (o.sheet ? "as the captions say" : o.develop.toneMap) + "\nwritten: " + written + "\n");
  return ExitStatus::DONE;
}

} // namespace

void addDevelopCommand(CLI::App& app, Command& chosen) {
  auto options = std::make_shared<DevelopCommandOptions>();
  DevelopCommandOptions& o = *options;
  CLI::App* command =
      app.add_subcommand("develop", "Map a linear picture to a display: exposure, tone mapping");
  command->add_option("picture", o.input, "A picture with linear values: .exr, .hdr, .pfm")
      ->required()
      ->type_name("PICTURE");
  addRepeatedOption(*command, "-o,--output", o.outputs,
                    "Picture to write, may be repeated: .png .jpg .tif; .html: a page with sliders for "
                    "exposure and a choice of tone operators; .apng .mp4: the film of a picture that "
                    "'recurse render --time-of-flight' has made")
      ->required()
      ->type_name("FILE");
  command->add_flag("--sheet", o.sheet, "Write a contact sheet of all tone operators instead of one picture");
  command->add_option("--frame-rate", o.frameRate, "Frames per second of .apng and .mp4 (default: 24)")
      ->type_name("FPS");
  o.develop.addTo(*command);
  command->add_flag("-q,--quiet", o.quiet, "Print errors and warnings only");
  command->footer("Order of operations: white balance, exposure, bloom, tone operator, encoding, dither.\n\n"
                  "Examples:\n"
                  "  recurse develop picture.exr -o picture.png\n"
                  "  recurse develop picture.exr -o bright.jpg --exposure auto+1 --tonemap aces\n"
                  "  recurse develop picture.exr -o soft.png --tonemap 'durand \"float sigmarange\" 0.3'\n"
                  "  recurse develop picture.exr -o evening.png --white-balance 3200 --bloom 0.3\n"
                  "  recurse develop picture.exr -o plain.png --exposure 0 --tonemap none\n"
                  "  OCIO=config.ocio recurse develop picture.exr -o film.tif --tonemap none --display ocio\n"
                  "  recurse develop picture.exr -o operators.png --sheet\n"
                  "  recurse develop picture.exr -o look.html\n"
                  "  recurse develop flight.exr -o flight.apng --exposure auto+1 --frame-rate 12");
  command->callback([options, &chosen] { chosen = [options] { return developPicture(*options); }; });
}

} // namespace recurse::apps
