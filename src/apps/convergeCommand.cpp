/** @file
 * `recurse converge`: error against time, for several settings.
 */
#include <chrono>
#include <cmath>
#include <filesystem>
#include <optional>

#include "apps/commands.h"
#include "apps/convergeReference.h"
#include "apps/interrupt.h"
#include "apps/namedRun.h"
#include "apps/optionText.h"
#include "apps/renderOptions.h"
#include "recurse/core/atomicFile.h"
#include "recurse/core/parallel.h"
#include "recurse/report/converge.h"

namespace recurse::apps {

namespace {

namespace fs = std::filesystem;

struct ConvergeOptions {
  RenderOptions render;
  std::string folder;
  std::vector<std::string> references, runs;
  std::optional<std::string> times, samples, photons, seeds, referenceError, referenceTime;
};

/** "100k" for 100000: short enough for file names and tables. */
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
    badUsage("only one of --times, --samples and --photons");
  Budgets out;
  Study sorted; // include() puts budgets in order and drops what is there twice
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

/** What the budgets say. */
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
      runs.push_back(parseRun("--run", name + "=--integrator " + name, o.render, refusedFor(kind)));
  }
  for (size_t i = 0; i < runs.size(); ++i)
    for (size_t j = 0; j < i; ++j)
      if (runs[i].name == runs[j].name) badUsage("--run " + runs[i].name + " is there twice");
  return runs;
}

/** All that decides the picture of a run but budget and seed. */
std::string settingsText(const Run& run, const Scene& scene, BudgetKind kind) {
  std::string out = run.integrator.type;
  for (const std::string& setting : settingsOf(run.integrator))
    if (kind != BudgetKind::PHOTONS || !setting.starts_with("photons ")) out += ", " + setting;
  if (kind == BudgetKind::PHOTONS)
    out += ", " + std::to_string(run.options.plan().settings(scene).samplesPerPixel) + " samples per pixel";
  if (run.options.adaptive) out += ", adaptive";
  return out;
}

/** The options of one picture. */
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

/** Guesses what is left of a study from what has been done. */
class TimeLeft {
 public:
  TimeLeft(const Study& study, const std::vector<Run>& runs) : study(study), runs(runs) {}

  /** Seconds of a cell; by the nearest budget of its run that is known, else of any run; negative: unknown.
   */
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

  /** Of all cells that are missing; negative: unknown. */
  double ofAll(const std::vector<uint64_t>& seeds, const std::vector<Budget>& budgets) const {
    double sum = 0;
    for (const Run& run : runs)
      for (const Budget& budget : budgets)
        for (uint64_t seed : seeds) {
          if (study.find(run.name, budget.text, seed)) continue;
          const double seconds = of(run.name, budget);
          if (seconds < 0) return -1;
          sum += seconds;
        }
    return sum;
  }

 private:
  const Study& study;
  const std::vector<Run>& runs;
};

void makeFolder(const std::string& folder) {
  std::error_code failure;
  fs::create_directories(fs::path(folder) / "cells", failure);
  if (failure) throw Error(folder + ": " + failure.message());
  checkFileWritable((fs::path(folder) / "converge.json").string());
}

/** Renders one cell; empty when it was interrupted. */
std::optional<ConvergeCell> renderCell(LoadedScene& loaded, const Run& run, const RenderOptions& options,
                                       const References& references, const std::string& fileName,
                                       const Rendering::Retell& retell) {
  Diagnostics diagnostics;
  const RenderPlan plan = options.plan();
  loaded.integratorDirective = options.integrator.directive(loaded.description.integrator);
  loaded.integrator = makeIntegrator(loaded.integratorDirective, options.lenient, diagnostics);
  diagnostics.throwIfErrors();
  try {
    const Rendering rendering(loaded, PathClasses(), plan, options, retell);
    if (rendering.interrupted()) return std::nullopt;
    const RenderReport report = rendering.report("recurse render");
    const Image picture = pictureOf(rendering.film(), report);
    writeImage(fileName, picture);
    ConvergeCell cell = measureCell(picture, references);
    cell.run = run.name;
    cell.seconds = rendering.statistics().renderSeconds;
    cell.samplesPerPixel = report.samplesPerPixel();
    cell.photons = double(rendering.statistics().photonsEmitted);
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

ExitStatus converge(const ConvergeOptions& o) {
  const Budgets budgets = budgetsOf(o);
  const RenderPlan plan = o.render.plan();
  const auto seedCount = static_cast<uint64_t>(o.seeds ? parseCount("--seeds", *o.seeds, 1, 10000) : 2);
  ReferencePlan referencePlan;
  if (o.referenceError) referencePlan.relMse = parseReal("--reference-error", *o.referenceError);
  if (!(referencePlan.relMse > 0)) badUsage("--reference-error: is to be above zero");
  if (o.referenceTime) referencePlan.seconds = parseDuration("--reference-time", *o.referenceTime);
  if (!o.references.empty() && (o.referenceError || o.referenceTime))
    badUsage("--reference-error and --reference-time are for references that are made, without --reference");
  std::vector<Run> runs = runsOf(o, budgets.kind);
  std::vector<Image> given;
  for (const std::string& name : o.references) given.push_back(readImage(name));

  const ThreadPool pool(plan.threads);
  // What the file says of its integrator counts; the options are for the runs.
  LoadedScene loaded = loadAndBuild(o.render.scene, plan.overrides, IntegratorOptions());
  const PixelBounds& crop = loaded.scene->film().crop;
  for (Run& run : runs) {
    Diagnostics diagnostics;
    try {
      const RenderOptions options = cellOptions(run, budgets.kind, budgets.list.front(), 0);
      run.integrator = options.integrator.directive(loaded.description.integrator);
    } catch (const Error& error) {
      throw Error("--run " + run.name + ": " + error.what(), error.status());
    }
    makeIntegrator(run.integrator, o.render.lenient, diagnostics);
    diagnostics.throwIfErrors();
  }
  for (size_t i = 0; i < given.size(); ++i)
    if (given[i].width != crop.width() || given[i].height != crop.height())
      badUsage("--reference: " + o.references[i] + " has " + std::to_string(given[i].width) + "x" +
               std::to_string(given[i].height) + " pixels, the scene is rendered with " +
               std::to_string(crop.width()) + "x" + std::to_string(crop.height()));
  makeFolder(o.folder);
  if (o.render.verbose) std::fputs(sceneReport(loaded).c_str(), stderr);

  const std::string sceneHash = contentHash(loaded.description);
  Study study;
  study.kind = budgets.kind;
  std::string part = std::to_string(crop.width()) + "x" + std::to_string(crop.height()) + " pixels";
  if (o.render.cropWindow) part += " of the window " + *o.render.cropWindow;
  study.identity = {{"content of the scene", sceneHash},
                    {"reference", given.empty() ? "made to relMSE " + formatted("%.4g", referencePlan.relMse)
                                                : std::to_string(given.size()) + " given"},
                    {"picture", part},
                    {"threads", std::to_string(threadCount())},
                    {"program", std::string("Recurse ") + VERSION}};
  for (const Run& run : runs)
    study.runs.push_back({run.name, settingsText(run, *loaded.scene, budgets.kind)});
  study.budgets = budgets.list;
  const uint64_t firstSeed = plan.settings(*loaded.scene).seed;
  for (uint64_t i = 0; i < seedCount; ++i) study.seeds.push_back(firstSeed + i);
  const std::vector<Budget> wantedBudgets = study.budgets;
  const std::vector<uint64_t> wantedSeeds = study.seeds;
  const std::string file = (fs::path(o.folder) / "converge.json").string();
  Study found;
  if (fs::exists(file)) {
    found = readStudy(file);
    requireSameStudy(found, study, o.folder);
    if (!found.cells.empty()) referencePlan.relMse = INFINITY; // they were measured against what there is
  }

  const GracefulStop graceful;
  const References references = given.empty()
                                    ? ownReferences(loaded, o.render, referencePlan, sceneHash, o.folder)
                                    : makeReferences(given, o.references);
  if (!o.render.quiet) std::fputs(("reference: " + references.description + "\n").c_str(), stderr);
  study.identity.push_back({"content of the reference", references.hash()});
  if (!found.runs.empty()) requireSameStudy(found, study, o.folder);
  study.include(found);

  const size_t total = runs.size() * wantedBudgets.size() * wantedSeeds.size();
  size_t done = 0;
  const TimeLeft timeLeft(study, runs);
  bool interrupted = false;
  // Small budgets first, and one seed after the other, so that an interrupted study has something of each
  // run.
  for (const Budget& budget : wantedBudgets)
    for (uint64_t seed : wantedSeeds)
      for (const Run& run : runs) {
        ++done;
        if (interrupted || study.find(run.name, budget.text, seed)) continue;
        if (graceful.flag()) {
          interrupted = true;
          continue;
        }
        const double all = timeLeft.ofAll(wantedSeeds, wantedBudgets), own = timeLeft.of(run.name, budget);
        const std::string phase = "picture " + std::to_string(done) + " of " + std::to_string(total) + ", " +
                                  run.name + " " + budget.text + " seed " + std::to_string(seed);
        const auto retell = [&](RenderProgress& p) {
          p.phase = phase;
          p.secondsLeft = all < 0 || p.secondsLeft < 0 ? -1 : p.secondsLeft + std::max(0.0, all - own);
        };
        const std::string picture =
            (fs::path(o.folder) / cellPictureName(run.name, budget.text, seed)).string();
        std::optional<ConvergeCell> cell = renderCell(
            loaded, run, cellOptions(run, budgets.kind, budget, seed), references, picture, retell);
        if (!cell) {
          interrupted = true;
          continue;
        }
        cell->budget = budget.text;
        cell->seed = seed;
        study.cells.push_back(*cell);
        writeFileAtomically(file, studyJson(study));
        if (!o.render.quiet)
          std::fputs((phase + ": " + formatted("%.3g s, ", cell->seconds) +
                      formatted("%.4g", cell->samplesPerPixel) + " samples per pixel, " + errorText(*cell) +
                      leftText(timeLeft.ofAll(wantedSeeds, wantedBudgets)) + "\n")
                         .c_str(),
                     stderr);
      }

  StudyReport report = reportOf(study, references, o.folder);
  report.title = fs::path(o.render.scene).filename().string();
  report.label = part + ", " + std::to_string(threadCount()) +
                 (threadCount() == 1 ? " thread, " : " threads, ") + std::to_string(study.seeds.size()) +
                 (study.seeds.size() == 1 ? " seed" : " seeds");
  if (interrupted) report.label += ", interrupted";
  if (!report.points.empty()) {
    const std::string remark = writeReport(report, o.folder);
    if (!remark.empty()) std::fputs((remark + "\n").c_str(), stderr);
    print(studyTable(report));
  }
  if (interrupted) {
    std::fputs(("interrupted with " + std::to_string(study.cells.size()) +
                " pictures kept; the same command goes on with the rest\n")
                   .c_str(),
               stderr);
    return ExitStatus::INTERRUPTED;
  }
  if (!o.render.quiet) {
    const std::string folder = o.folder.ends_with('/') ? o.folder : o.folder + "/";
    std::fputs(("written: " + folder + "index.html, plot.png, cells.csv, points.csv, converge.json, cells/\n")
                   .c_str(),
               stderr);
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
      ->add_option(
          "-o,--output", o.folder,
          "Folder for index.html, plot.png, cells.csv, points.csv, converge.json and the pictures; made "
          "if need be; what is finished there is kept and gone on with")
      ->required()
      ->type_name("DIR");
  command
      ->add_option(
          "--reference", o.references,
          "What the picture should be: one; two whose noise is independent; or the best one and two that "
          "are independent (default: two are made by path, or by sppm where path cannot find all light)")
      ->expected(1, 3)
      ->type_name("REF [A] [B]");
  command
      ->add_option("--run", o.runs,
                   "Settings under a name, several allowed; any option of 'recurse render' that changes the "
                   "picture (default: path and photonmap)")
      ->expected(1)
      ->take_all()
      ->type_name("NAME=\"OPTIONS\"");
  o.render.addTo(*command);
  for (const char* taken : {"--photons", "--spp", "--time-limit", "--stats"})
    command->remove_option(command->get_option(taken));
  const auto add = [&](const char* name, auto& target, const char* type, const char* description) {
    command->add_option(name, target, description)->type_name(type);
  };
  add("--times", o.times, "T,T,...", "Budgets of time: 2s,4s,8s (default: 1s,2s,4s,8s)");
  add("--samples", o.samples, "N,N,...", "Budgets of samples per pixel");
  add("--photons", o.photons, "N,N,...", "Budgets of photons: 10k,100k,1M");
  add("--seeds", o.seeds, "N", "Pictures of each setting and budget; two or more tell bias (default: 2)");
  add("--reference-error", o.referenceError, "RELMSE",
      "Of references that are made: their mean's relMSE to stop at, at 97.5% sure (default: 0.001)");
  add("--reference-time", o.referenceTime, "TIME",
      "Longest time for making references (default: none); says what was reached");
  command->footer(
      "Every run is rendered with every budget and seed. relMSE is mean((x-r)^2/(r^2+0.01)), and with two\n"
      "independent references mean((x-a)(x-b)/(r^2+0.01)), free of their noise. Variance is that over the\n"
      "seeds; bias^2 = relMSE - variance. Options beside --run are for all runs and for the making of\n"
      "references, which take the scene's limit of path lengths.\n\n"
      "Examples:\n"
      "  recurse converge scene.pbrt -o study\n"
      "  recurse converge scene.pbrt -o study --reference a.exr b.exr --times 2s,4s,8s,16s \\\n"
      "      --run path=\"--integrator path\" --run pm=\"--integrator photonmap --photons 1M\"\n"
      "  recurse converge scene.pbrt -o radii --photons 10k,100k,1M --seeds 4 \\\n"
      "      --run wide=\"--radius 0.2 --spp 16\" --run narrow=\"--radius 0.05 --spp 16\"\n\n"
      "Ctrl-C keeps all pictures that are finished, and the same command goes on. plot.png needs gnuplot.");
  command->callback([options, &chosen] { chosen = [options] { return converge(*options); }; });
}

} // namespace recurse::apps
