/** @file
 * `recurse split`: a render as an array of jobs that a scheduler, or a shell, runs one by one.
 */
#include <cctype>
#include <filesystem>
#include <string_view>

#include "apps/commands/commands.h"
#include "apps/options/optionText.h"
#include "apps/options/renderOptions.h"
#include "recurse/core/io/atomicFile.h"
#include "recurse/core/io/terminalText.h"
#include "recurse/transport/integrator/sceneNames.h"

namespace recurse::apps {

namespace {

struct SplitOptions {
  RenderOptions render;
  std::string folder, parts, paths;
};

/** Largest number of jobs that schedulers accept by default (Slurm: MaxArraySize 1001). */
constexpr int64_t MAX_PARTS = 1000;

/** First sample of part `index`. It is the first of a pass if there are enough passes, because two parts that
 * share a pass would both shoot its photons. */
int64_t beginOf(int64_t index, int64_t parts, int64_t samples, const Passes& passes) {
  const int64_t count = passes.minSamples();
  return passes.schedule() == PassSchedule::FIXED && count >= parts
             ? passes.begin(index * count / parts, samples)
             : index * samples / parts;
}

std::string partName(int64_t index) { return formatted("part-%03lld.rck", static_cast<long long>(index)); }

/** Writes an executable script. */
void writeScript(const std::filesystem::path& file, const std::string& text) {
  writeFileAtomically(file.string(), text);
  using std::filesystem::perms;
  std::filesystem::permissions(file, perms::owner_exec | perms::group_exec | perms::others_exec,
                               std::filesystem::perm_options::add);
}

/** Rejects control characters: a line break in a name would end a line of the script. */
void requireOneLine(const std::string& option, const std::string& name) {
  if (hasControlCharacters(name))
    badUsage(option + ": " + name +
             ": the name has line breaks or control characters, which a script cannot contain");
}

/** Split render: data that its scripts share. */
struct Job {
  std::filesystem::path folder;
  std::string settings; ///< options of `recurse render`
  int64_t parts = 1, samples = 1;
  Passes passes = Passes::oneMap();
};

/** Shell lines that set RECURSE and enter the script's folder, even if it has been moved. */
std::string scriptStart() {
  return "RECURSE=${RECURSE:-" + shellQuoted(std::filesystem::read_symlink("/proc/self/exe").string()) +
         "}\n"
         "# Slurm runs a copy of the script that it was given, and knows where that was.\n"
         "script=$0\n"
         "[ -f \"$(dirname -- \"$script\")/part.sh\" ] ||\n"
         "  script=$(scontrol show job \"$SLURM_JOB_ID\" | sed -n '/^ *Command=/{s///p;q;}')\n"
         "cd -- \"$(dirname -- \"$script\")\" || exit 1\n";
}

std::string partScript(const Job& job) {
  std::string ranges;
  for (int64_t i = 0; i < job.parts; ++i)
    ranges += std::to_string(i) +
              ") range=" + std::to_string(beginOf(i, job.parts, job.samples, job.passes)) + ":" +
              std::to_string(beginOf(i + 1, job.parts, job.samples, job.passes)) + " file=" + partName(i) +
              " ;;\n";
  return "#!/bin/sh\n"
         "# part.sh N: renders part N, or continues it.\n" +
         scriptStart() + "case \"$1\" in\n" + ranges +
         "*) echo \"there is no part '$1'\" >&2; exit 2 ;;\nesac\n"
         "exec \"$RECURSE\" render " +
         job.settings + " --sample-range $range --checkpoint $file --resume --progress plain\n";
}

std::string mergeScript(const Job& job) {
  std::string names;
  for (int64_t i = 0; i < job.parts; ++i) names += " " + partName(i);
  return "#!/bin/sh\n"
         "# merge.sh [OPTION...]: the picture, once all parts are there; with --partial, of what there "
         "is.\n" +
         scriptStart() + "exec \"$RECURSE\" merge" + names + " -o picture.exr -o picture.png \"$@\"\n";
}

std::string localScript(const Job& job) {
  return "#!/bin/sh\n"
         "# All parts one after the other, then the picture. Parts that failed are run again by the next "
         "call.\n" +
         scriptStart() + "part=0\nwhile [ $part -lt " + std::to_string(job.parts) +
         " ]; do\n  ./part.sh $part || echo \"part $part failed\" >&2\n  part=$((part + 1))\ndone\n"
         "exec ./merge.sh\n";
}

/** Array job. A job that is cancelled or requeued gets SIGTERM, and writes its checkpoint. */
std::string slurmScript(const Job& job) {
  return "#!/bin/sh\n"
         "# sbatch slurm.sh; then: sbatch --dependency=afterany:JOB merge.sh\n"
         "#SBATCH --job-name=recurse\n"
         "#SBATCH --array=0-" +
         std::to_string(job.parts - 1) + "\n#SBATCH --requeue\n#SBATCH --output=/dev/null\n" + scriptStart() +
         "exec ./part.sh \"$SLURM_ARRAY_TASK_ID\" "
         ">>\"slurm-${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID.log\" 2>&1\n";
}

/** Number of samples to be split. Throws Error (BAD_USAGE) for a render that cannot be split. */
int64_t samplesToSplit(const RenderPlan& plan) {
  if (plan.adaptive || plan.timeLimit > 0 || plan.errorTarget > 0)
    badUsage("split: --adaptive, --time-limit and --error-target depend on the whole picture; use --spp N");
  if (!plan.samples) badUsage("split: needs --spp N, the number of samples per pixel that the parts divide");
  return *plan.samples;
}

ExitStatus splitRender(SplitOptions o) {
  const RenderPlan plan = o.render.plan();
  Job job;
  job.samples = samplesToSplit(plan);
  job.parts = parseCount("--parts", o.parts, 1, std::min(job.samples, MAX_PARTS));
  if (!o.paths.empty()) PathClasses::check({{o.paths, o.paths}});
  // Jobs run in any folder.
  o.render.scene = std::filesystem::absolute(o.render.scene).string();
  job.folder = std::filesystem::absolute(o.folder).lexically_normal();
  requireOneLine("SCENE", o.render.scene);
  requireOneLine("-o", job.folder.string());
  requireOneLine("--paths", o.paths);
  const LoadedScene loaded = loadAndBuild(o.render.scene, plan.overrides, o.render.integrator);
  const PathClasses classes = o.paths.empty() ? PathClasses()
                                              : sceneClasses(std::vector<PathClass>{{o.paths, o.paths}},
                                                             *loaded.scene, loaded.integrator.get());
  job.passes = loaded.integrator->passes(static_cast<int>(job.samples));
  if (job.passes.minSamples() > job.samples)
    badUsage("--spp: " + std::to_string(job.passes.minSamples()) + " passes need at least one sample each");
  std::error_code reason;
  std::filesystem::create_directories(job.folder, reason);
  if (reason) throw Error("-o: " + job.folder.string() + ": " + reason.message());
  job.settings = o.render.text(loaded, plan.settings(*loaded.scene)) +
                 (o.paths.empty() ? "" : " --paths " + shellQuoted(o.paths)) +
                 (plan.threads > 0 ? " --nthreads " + std::to_string(plan.threads) : "");
  requireOneLine("split", job.settings);

  writeScript(job.folder / "part.sh", partScript(job));
  writeScript(job.folder / "merge.sh", mergeScript(job));
  writeScript(job.folder / "local.sh", localScript(job));
  writeScript(job.folder / "slurm.sh", slurmScript(job));
  if (!o.render.quiet)
    say(job.folder.string() + ": " + std::to_string(job.parts) + " parts of about " +
        formatted("%.4g", double(job.samples) / double(job.parts)) +
        " samples per pixel; run slurm.sh with sbatch, or local.sh, then merge.sh\n");
  return ExitStatus::DONE;
}

} // namespace

void addSplitCommand(CLI::App& app, Command& chosen) {
  auto options = std::make_shared<SplitOptions>();
  SplitOptions& o = *options;
  CLI::App* command = app.add_subcommand("split", "Write scripts that render a scene in many jobs");
  o.render.addSceneTo(*command);
  command->add_option("--parts", o.parts, "Number of jobs")->required()->type_name("N");
  command->add_option("-o,--output", o.folder, "Folder for the scripts, the parts and the picture")
      ->required()
      ->type_name("FOLDER");
  command
      ->add_option("--paths", o.paths,
                   "Render only light paths of this class, such as 'LS+DE'; see 'recurse classes'")
      ->type_name("EXPR");
  o.render.addTo(*command);
  command->footer(
      "Writes part.sh, which renders one part; slurm.sh, a job array for Slurm; local.sh, which renders\n"
      "all parts in sequence; merge.sh, which adds them to picture.exr and picture.png, and reports\n"
      "missing parts. A part that was killed continues from its checkpoint when it is run again. The\n"
      "picture is bit-identical to that of one render. Set RECURSE=FILE in the environment to choose the\n"
      "program.\n\n"
      "Examples:\n"
      "  recurse split scene.pbrt --parts 64 --spp 4096 -o job\n"
      "  sbatch job/slurm.sh\n"
      "  job/merge.sh --partial --exposure 1");
  command->callback([options, &chosen] { chosen = [options] { return splitRender(*options); }; });
}

} // namespace recurse::apps
