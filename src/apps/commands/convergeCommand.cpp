/** @file
 * `recurse converge`: error against time, for several settings.
 */
#include <chrono>
#include <cmath>
#include <filesystem>
#include <optional>

#include "apps/commands/commands.h"
#include "apps/converge/convergeReference.h"
#include "apps/options/namedRun.h"
#include "apps/options/optionText.h"
#include "apps/options/renderOptions.h"
#include "apps/run/interrupt.h"
#include "apps/run/outputFiles.h"
#include "recurse/core/io/atomicFile.h"
#include "recurse/core/io/fileLock.h"
#include "recurse/core/threads/parallel.h"
#include "recurse/report/converge/converge.h"

namespace recurse::apps {

namespace {

namespace fs = std::filesystem;

struct ConvergeOptions {
  RenderOptions render;
  std::string folder;
  std::vector<std::string> references, runs;
  std::optional<std::string> times, samples, photons, seeds, referenceError, referenceTime;
};

/** Short name of a count for file names and tables: "100k" for 100000. */
std::string countName(int64_t count) {
  if (count % 1000000 == 0) return std::to_string(count / 1000000) + "M";
  if (count % 1000 == 0) return std::to_string(count / 1000) + "k";
  return std::to_string(count);
}

struct Budgets {
  BudgetKind kind = BudgetKind::TIME;
  std::vector<Budget> list;
};

Budgets budgetsOf(const ConvergeOptions& o) {
  if (int(o.times.has_value()) + int(o.samples.has_value()) + int(o.photons.has_value()) > 1)
    badUsage("use only one of --times, --samples and --photons");
  Budgets out;
  Study sorted; // include() sorts budgets and removes duplicates
  const auto add = [&](double amount, const std::string& text) {
    Study one;
    one.budgets = {{amount, text}};
    sorted.include(one);
  };
  if (o.samples) {
    out.kind = BudgetKind::SAMPLES;
    for (const std::string& text : split(*o.samples, ',')) {
      const int64_t count = parseCount("--samples", text, 1, 1 << 30);
      add(double(count), countName(count));
    }
  } else if (o.photons) {
    out.kind = BudgetKind::PHOTONS;
    for (const std::string& text : split(*o.photons, ',')) {
      const int64_t count = parseCount("--photons", text, 1, 2147483647);
      add(double(count), countName(count));
    }
  } else {
    for (const std::string& text : split(o.times.value_or("1s,2s,4s,8s"), ',')) {
      const double seconds = parseDuration("--times", text);
      add(seconds, formatted("%.6g", seconds) + "s");
    }
  }
  out.list = sorted.budgets;
  return out;
}

/** Options that the budgets replace, so that runs may not have them. */
std::vector<const char*> refusedFor(BudgetKind kind) {
  return kind == BudgetKind::PHOTONS ? std::vector<const char*>{"--time-limit", "--photons"}
                                     : std::vector<const char*>{"--time-limit", "--spp"};
}

std::vector<Run> runsOf(const ConvergeOptions& o, BudgetKind kind) {
  std::vector<Run> runs;
  for (const std::string& text : o.runs) runs.push_back(parseRun("--run", text, o.render, refusedFor(kind)));
  if (runs.empty()) {
    const std::vector<std::string> names =
        o.render.integrator.named() ? std::vector<std::string>{o.render.integrator.integratorName()}
                                    : std::vector<std::string>{"path", DEFAULT_INTEGRATOR};
    for (const std::string& name : names)
      runs.push_back(parseRun("--run", formatted("%s=--integrator %s", name.c_str(), name.c_str()), o.render,
                              refusedFor(kind)));
  }
  for (size_t i = 0; i < runs.size(); ++i)
    for (size_t j = 0; j < i; ++j)
      if (runs[i].name == runs[j].name)
        badUsage("--run " + runs[i].name + " is given twice; use different names");
  return runs;
}

/** All settings that determine the picture of a run, except for budget and seed. */
std::string settingsText(const Run& run, const Scene& scene, BudgetKind kind) {
  std::string out = run.integrator.type;
  for (const std::string& setting : settingsOf(run.integrator))
    if (kind != BudgetKind::PHOTONS || !setting.starts_with("photons ")) out += ", " + setting;
  if (kind == BudgetKind::PHOTONS)
    out += ", " + std::to_string(run.options.plan().settings(scene).samplesPerPixel) + " samples per pixel";
  if (run.options.adaptive) out += ", adaptive";
  return out;
}

/** Options of one picture. */
RenderOptions cellOptions(const Run& run, BudgetKind kind, const Budget& budget, uint64_t seed) {
  RenderOptions options = run.options;
  options.seed = std::to_string(seed);
  options.verbose = false;
  if (kind == BudgetKind::TIME)
    options.timeLimit = budget.text;
  else if (kind == BudgetKind::SAMPLES)
    options.samples = budget.text;
  else
    options.integrator.set("--photons", budget.text);
  return options;
}

/** A cell of the grid of runs, budgets and seeds. */
struct PlannedCell {
  const Run& run;
  const Budget& budget;
  uint64_t seed;
};

/** Order of cells: small budgets first, then seed by seed, so that an interrupted study has cells of each
 * run. */
std::vector<PlannedCell> cellsInOrder(const std::vector<Run>& runs, const std::vector<Budget>& budgets,
                                      const std::vector<uint64_t>& seeds) {
  std::vector<PlannedCell> cells;
  for (const Budget& budget : budgets)
    for (uint64_t seed : seeds)
      for (const Run& run : runs) cells.push_back({run, budget, seed});
  return cells;
}

/** Estimate of the remaining time of a study from its finished cells. */
class TimeLeft {
 public:
  TimeLeft(const Study& study, const std::vector<PlannedCell>& planned) : study(study), planned(planned) {}

  /** Estimated time of a cell [s], from the nearest known budget of the same run, or else of any run.
   * Negative: unknown. */
  double of(const std::string& run, const Budget& budget) const {
    if (study.kind == BudgetKind::TIME) return budget.amount;
    double best = -1, distance = INFINITY;
    for (const ConvergeCell& cell : study.cells)
      for (const Budget& known : study.budgets) {
        if (known.text != cell.budget) continue;
        const double away = std::abs(std::log(known.amount / budget.amount)) + (cell.run == run ? 0 : 1e3);
        if (away >= distance) continue;
        distance = away;
        best = cell.seconds * budget.amount / known.amount;
      }
    return best;
  }

  /** Estimated time of all missing cells [s]; negative: unknown. */
  double ofAll() const {
    double sum = 0;
    for (const PlannedCell& cell : planned) {
      if (study.find(cell.run.name, cell.budget.text, cell.seed)) continue;
      const double seconds = of(cell.run.name, cell.budget);
      if (seconds < 0) return -1;
      sum += seconds;
    }
    return sum;
  }

 private:
  const Study& study;
  const std::vector<PlannedCell>& planned;
};

std::string studyFile(const std::string& folder) { return (fs::path(folder) / "converge.json").string(); }

void makeFolder(const std::string& folder) {
  std::error_code failure;
  fs::create_directories(fs::path(folder) / "cells", failure);
  if (failure) throw Error(folder + ": " + failure.message());
  checkFileWritable(studyFile(folder));
}

/** Throws Error if an input is among the files that the folder gets. */
void checkFiles(const ConvergeOptions& o, const std::vector<std::string>& sceneFiles) {
  std::vector<InputFile> inputs = inputFiles("a file of the scene", sceneFiles);
  for (const std::string& name : o.references) inputs.push_back({"a reference", name});
  requireOutsideOf((fs::path(o.folder) / "cells").string(), {}, inputs);
  std::vector<OutputFile> outputs;
  for (const char* name : {"index.html", "plot.png", "cells.csv", "points.csv", "converge.json"})
    outputs.push_back({"-o", (fs::path(o.folder) / name).string()});
  if (o.references.empty()) outputs.push_back({"-o", (fs::path(o.folder) / "reference.exr").string()});
  requireDistinctFiles(outputs, inputs);
}

/** Renders one cell; empty when it was interrupted. */
std::optional<ConvergeCell> renderCell(LoadedScene& loaded, const Run& run, const RenderOptions& options,
                                       const References& references, const std::string& fileName,
                                       const Retell& retell) {
  Diagnostics diagnostics;
  const RenderPlan plan = options.plan();
  loaded.integratorDirective = options.integrator.directive(loaded.description.integrator);
  loaded.integrator = makeIntegrator(loaded.integratorDirective, options.lenient, diagnostics);
  diagnostics.throwIfErrors();
  try {
    const RenderResult result = renderLoaded(loaded, PathClasses(), plan, options, retell);
    if (result.isInterrupted()) return std::nullopt;
    const RenderReport report = result.report("recurse render");
    const Image picture = pictureOf(result.film, report);
    writeImage(fileName, picture);
    ConvergeCell cell = measureCell(picture, references);
    cell.run = run.name;
    cell.seconds = result.statistics.renderSeconds;
    cell.samplesPerPixel = report.samplesPerPixel();
    cell.photons = double(result.statistics.photonsEmitted);
    return cell;
  } catch (const Error& error) {
    if (error.status() == ExitStatus::INTERRUPTED) return std::nullopt;
    throw;
  }
}

std::string errorText(const ConvergeCell& cell) {
  return std::isfinite(cell.relMseNoiseFree) ? "relMSE noise-free " + formatted("%.4g", cell.relMseNoiseFree)
                                             : "relMSE " + formatted("%.4g", cell.relMse);
}

std::string leftText(double seconds) { return seconds > 0 ? "; " + durationText(seconds) + " left" : ""; }

/** Parsed options, without the parts that depend on the scene. */
struct ConvergePlan {
  Budgets budgets;
  RenderPlan render;
  ReferencePlan reference;
  std::vector<Image> references; ///< pictures of --reference
  std::vector<Run> runs;
  uint64_t seedCount = 2;
};

ConvergePlan planOf(const ConvergeOptions& o) {
  ConvergePlan plan;
  plan.budgets = budgetsOf(o);
  plan.render = o.render.plan();
  if (o.seeds) plan.seedCount = static_cast<uint64_t>(parseCount("--seeds", *o.seeds, 1, 10000));
  if (o.referenceError) plan.reference.relMse = parseReal("--reference-error", *o.referenceError);
  if (!(plan.reference.relMse > 0)) badUsage("--reference-error: must be more than 0");
  if (o.referenceTime) plan.reference.seconds = parseDuration("--reference-time", *o.referenceTime);
  if (!o.references.empty() && (o.referenceError || o.referenceTime))
    badUsage("--reference-error and --reference-time are for references that this command renders; remove "
             "them, or --reference");
  plan.runs = runsOf(o, plan.budgets.kind);
  for (const std::string& name : o.references) plan.references.push_back(readImage(name));
  return plan;
}

/** Sets the integrator of each run, and makes each once to find errors before anything is rendered. */
void chooseIntegrators(ConvergePlan& plan, const ParsedDirective& inScene, bool lenient) {
  for (Run& run : plan.runs) {
    Diagnostics diagnostics;
    try {
      const RenderOptions options = cellOptions(run, plan.budgets.kind, plan.budgets.list.front(), 0);
      run.integrator = options.integrator.directive(inScene);
    } catch (const Error& error) {
      throw Error("--run " + run.name + ": " + error.what(), error.status());
    }
    makeIntegrator(run.integrator, lenient, diagnostics);
    diagnostics.throwIfErrors();
  }
}

std::string sizeText(int width, int height) { return std::to_string(width) + "x" + std::to_string(height); }

void requireSize(const std::vector<Image>& references, const std::vector<std::string>& names,
                 const PixelBounds& crop) {
  for (size_t i = 0; i < references.size(); ++i)
    if (references[i].width != crop.width() || references[i].height != crop.height())
      badUsage("--reference: " + names[i] + " has " + sizeText(references[i].width, references[i].height) +
               " pixels, but the scene has " + sizeText(crop.width(), crop.height()));
}

/** Description of the rendered part of the picture. */
std::string partText(const ConvergeOptions& o, const PixelBounds& crop) {
  return sizeText(crop.width(), crop.height()) + " pixels" +
         (o.render.cropWindow ? " of the window " + *o.render.cropWindow : "");
}

/** Study as requested, without cells and without the identity of its reference. */
Study plannedStudy(const ConvergeOptions& o, const ConvergePlan& plan, const Scene& scene,
                   const std::string& sceneHash) {
  Study study;
  study.kind = plan.budgets.kind;
  study.identity = {{"content of the scene", sceneHash},
                    {"reference", plan.references.empty()
                                      ? "made to relMSE " + formatted("%.4g", plan.reference.relMse)
                                      : std::to_string(plan.references.size()) + " given"},
                    {"picture", partText(o, scene.film().crop)},
                    {"threads", std::to_string(threadCount())},
                    {"program", std::string("Recurse ") + VERSION}};
  for (const Run& run : plan.runs) study.runs.push_back({run.name, settingsText(run, scene, study.kind)});
  study.budgets = plan.budgets.list;
  const uint64_t firstSeed = plan.render.settings(scene).seed;
  for (uint64_t i = 0; i < plan.seedCount; ++i) study.seeds.push_back(firstSeed + i);
  return study;
}

/** Renders the cells that are missing, and writes the study after each. False when it was interrupted. */
bool renderMissingCells(Study& study, const std::vector<PlannedCell>& planned, LoadedScene& loaded,
                        const References& references, const ConvergeOptions& o,
                        const GracefulStop& graceful) {
  const TimeLeft timeLeft(study, planned);
  for (size_t i = 0; i < planned.size(); ++i) {
    const auto& [run, budget, seed] = planned[i];
    if (study.find(run.name, budget.text, seed)) continue;
    if (graceful.flag()) return false;
    const double all = timeLeft.ofAll(), own = timeLeft.of(run.name, budget);
    const std::string phase = "picture " + std::to_string(i + 1) + " of " + std::to_string(planned.size()) +
                              ", " + run.name + " " + budget.text + " seed " + std::to_string(seed);
    const auto retell = [&](RenderProgress& p) {
      p.phase = phase;
      p.secondsLeft = all < 0 || p.secondsLeft < 0 ? -1 : p.secondsLeft + std::max(0.0, all - own);
    };
    const std::string picture = (fs::path(o.folder) / cellPictureName(run.name, budget.text, seed)).string();
    std::optional<ConvergeCell> cell =
        renderCell(loaded, run, cellOptions(run, study.kind, budget, seed), references, picture, retell);
    if (!cell) return false;
    cell->budget = budget.text;
    cell->seed = seed;
    study.cells.push_back(*cell);
    writeFileAtomically(studyFile(o.folder), studyJson(study));
    if (!o.render.quiet)
      say(phase + ": " + formatted("%.3g s, ", cell->seconds) + formatted("%.4g", cell->samplesPerPixel) +
          " samples per pixel, " + errorText(*cell) + leftText(timeLeft.ofAll()) + "\n");
  }
  return true;
}

/** Writes and prints the results up to now. True if there is a plot. */
bool tellStudy(const Study& study, const References& references, const ConvergeOptions& o,
               const PixelBounds& crop, bool isComplete) {
  StudyReport report = reportOf(study, references, o.folder);
  report.title = fs::path(o.render.scene).filename().string();
  report.label = partText(o, crop) + ", " + std::to_string(threadCount()) +
                 (threadCount() == 1 ? " thread, " : " threads, ") + std::to_string(study.seeds.size()) +
                 (study.seeds.size() == 1 ? " seed" : " seeds") + (isComplete ? "" : ", interrupted");
  if (report.points.empty()) return false;
  const std::string remark = writeReport(report, o.folder);
  if (!remark.empty()) say(remark + "\n");
  print(studyTable(report));
  return remark.empty();
}

ExitStatus converge(const ConvergeOptions& o) {
  ConvergePlan plan = planOf(o);
  const ThreadPool pool(plan.render.threads);
  // The scene keeps the integrator of its file; integrator options are for the runs.
  LoadedScene loaded = loadAndBuild(o.render.scene, plan.render.overrides, IntegratorOptions());
  const PixelBounds& crop = loaded.scene->film().crop;
  chooseIntegrators(plan, loaded.description.integrator, o.render.lenient);
  checkFiles(o, loaded.files);
  requireSize(plan.references, o.references, crop);
  makeFolder(o.folder);
  const FileLock lock(folderName(o.folder));
  if (o.render.verbose) say(sceneReport(loaded));

  const std::string sceneHash = contentHash(loaded.description);
  Study study = plannedStudy(o, plan, *loaded.scene, sceneHash), found;
  const std::vector<PlannedCell> planned = cellsInOrder(plan.runs, plan.budgets.list, study.seeds);
  if (fs::exists(studyFile(o.folder))) {
    found = readStudy(studyFile(o.folder));
    requireSameStudy(found, study, o.folder);
    if (!found.cells.empty()) plan.reference.relMse = INFINITY; // existing cells need the reference as it is
  }

  const GracefulStop graceful;
  const References references = plan.references.empty()
                                    ? ownReferences(loaded, o.render, plan.reference, sceneHash, o.folder)
                                    : makeReferences(plan.references, o.references);
  if (!o.render.quiet) say("reference: " + references.description + "\n");
  study.identity.push_back({"content of the reference", references.hash()});
  if (!found.runs.empty()) requireSameStudy(found, study, o.folder);
  study.include(found);

  const bool isComplete = renderMissingCells(study, planned, loaded, references, o, graceful);
  const bool isPlotted = tellStudy(study, references, o, crop, isComplete);
  if (!isComplete) {
    say("interrupted with " + std::to_string(study.cells.size()) +
        " pictures kept; run the same command to render the rest\n");
    return ExitStatus::INTERRUPTED;
  }
  if (!o.render.quiet) {
    say("written: " + folderName(o.folder) + "index.html, " + (isPlotted ? "plot.png, " : "") +
        "plot.gp, cells.csv, points.csv, converge.json, cells/\n");
  }
  return ExitStatus::DONE;
}

} // namespace

void addConvergeCommand(CLI::App& app, Command& chosen) {
  auto options = std::make_shared<ConvergeOptions>();
  ConvergeOptions& o = *options;
  CLI::App* command =
      app.add_subcommand("converge", "Measure error against time, for several integrators and settings");
  o.render.addSceneTo(*command);
  command
      ->add_option("-o,--output", o.folder,
                   "Folder for index.html, plot.png, cells.csv, points.csv, converge.json and the pictures; "
                   "it is created if needed. An existing study is continued")
      ->required()
      ->type_name("DIR");
  command
      ->add_option("--reference", o.references,
                   "Reference pictures: one; two with independent noise; or the best one and two independent "
                   "ones (default: two are rendered by path, or by sppm if path cannot find all light)")
      ->expected(1, 3)
      ->type_name("REF [A] [B]");
  addRepeatedOption(*command, "--run", o.runs,
                    "Settings with a name; may be repeated. Any option of 'recurse render' that changes the "
                    "picture (default: path and photonmap)")
      ->type_name("NAME=\"OPTIONS\"");
  o.render.addTo(*command);
  for (const char* taken : {"--photons", "--spp", "--time-limit", "--stats"})
    command->remove_option(command->get_option(taken));
  const auto add = [&](const char* name, auto& target, const char* type, const char* description) {
    command->add_option(name, target, description)->type_name(type);
  };
  add("--times", o.times, "T,T,...", "Render times, such as 2s,4s,8s (default: 1s,2s,4s,8s)");
  add("--samples", o.samples, "N,N,...", "Numbers of samples per pixel");
  add("--photons", o.photons, "N,N,...", "Numbers of photons, such as 10k,100k,1M");
  add("--seeds", o.seeds, "N",
      "Number of pictures (seeds) for each setting and budget; bias needs two or more (default: 2)");
  add("--reference-error", o.referenceError, "RELMSE",
      "Target for rendered references: relMSE of their mean, reached with a confidence of 97.5% (default: "
      "0.001)");
  add("--reference-time", o.referenceTime, "TIME",
      "Maximum time to render references (default: none); the error that was reached is reported");
  command->footer(
      "Each run is rendered with each budget and seed. relMSE is mean((x-r)^2/(r^2+0.01)), and with two\n"
      "independent references mean((x-a)(x-b)/(r^2+0.01)), without their noise. Variance is over the\n"
      "seeds; bias^2 = relMSE - variance. Options outside of --run are for all runs and for rendered\n"
      "references; references use the scene's maximum path length.\n\n"
      "Examples:\n"
      "  recurse converge scene.pbrt -o study\n"
      "  recurse converge scene.pbrt -o study --reference a.exr b.exr --times 2s,4s,8s,16s \\\n"
      "      --run path=\"--integrator path\" --run pm=\"--integrator photonmap --photons 1M\"\n"
      "  recurse converge scene.pbrt -o radii --photons 10k,100k,1M --seeds 4 \\\n"
      "      --run wide=\"--radius 0.2 --spp 16\" --run narrow=\"--radius 0.05 --spp 16\"\n\n"
      "Ctrl-C keeps all finished pictures; run the same command to continue. plot.png needs gnuplot.");
  command->callback([options, &chosen] { chosen = [options] { return converge(*options); }; });
}

} // namespace recurse::apps
