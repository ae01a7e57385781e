/** @file
 * `recurse split`: a render as an array of jobs that a scheduler, or a shell, runs one by one.
 */
#include <filesystem>

#include "apps/commands.h"
#include "apps/optionText.h"
#include "apps/renderOptions.h"
#include "recurse/core/atomicFile.h"

namespace recurse::apps {

namespace {

struct SplitOptions {
  RenderOptions render;
  std::string folder, parts, paths;
};

/** More jobs than that no scheduler takes by default (Slurm: MaxArraySize 1001). */
constexpr int64_t MAX_PARTS = 1000;

/** Where part `index` begins: at the beginning of a pass where there are enough, for two parts would both
 * shoot a pass that they share. */
int64_t beginOf(int64_t index, int64_t parts, int64_t samples, int64_t passes) {
  return passes >= parts ? index * passes / parts * samples / passes : index * samples / parts;
}

std::string partName(int64_t index) { return formatted("part-%03lld.rck", static_cast<long long>(index)); }

/** A script that can be run. */
void writeScript(const std::filesystem::path& file, const std::string& text) {
  writeFileAtomically(file.string(), text);
  using std::filesystem::perms;
  std::filesystem::permissions(file, perms::owner_exec | perms::group_exec | perms::others_exec,
                               std::filesystem::perm_options::add);
}

ExitStatus splitRender(SplitOptions o) {
  const RenderPlan plan = o.render.plan();
  if (plan.adaptive || plan.timeLimit > 0 || plan.errorTarget > 0)
    badUsage(
        "split: --adaptive, --time-limit and --error-target depend on the whole picture; parts of it are "
        "samples of --spp");
  if (!plan.samples) badUsage("split: needs --spp N, the number of samples that are dealt out");
  const int64_t samples = *plan.samples;
  const int64_t parts = parseCount("--parts", o.parts, 1, std::min(samples, MAX_PARTS));
  const PathClasses classes =
      o.paths.empty() ? PathClasses() : PathClasses(std::vector<PathClass>{{o.paths, o.paths}});
  // Jobs run in any folder.
  o.render.scene = std::filesystem::absolute(o.render.scene).string();
  const LoadedScene loaded = loadAndBuild(o.render.scene, plan.overrides, o.render.integrator);
  const int64_t passes = loaded.integrator->passes(static_cast<int>(samples));
  if (passes > samples)
    badUsage("--spp: " + std::to_string(passes) + " passes need as many samples at least");
  const std::filesystem::path folder = std::filesystem::absolute(o.folder).lexically_normal();
  std::error_code reason;
  std::filesystem::create_directories(folder, reason);
  if (reason) throw Error("-o: " + folder.string() + ": " + reason.message());

  const std::string in = shellQuoted(folder.string());
  const std::string recurse =
      "RECURSE=${RECURSE:-" + shellQuoted(std::filesystem::read_symlink("/proc/self/exe").string()) + "}\n";
  const std::string settings = o.render.text(loaded, plan.settings(*loaded.scene)) +
                               (o.paths.empty() ? "" : " --paths " + shellQuoted(o.paths)) +
                               (plan.threads > 0 ? " --nthreads " + std::to_string(plan.threads) : "");
  std::string ranges, names;
  for (int64_t i = 0; i < parts; ++i) {
    ranges += std::to_string(i) + ") range=" + std::to_string(beginOf(i, parts, samples, passes)) + ":" +
              std::to_string(beginOf(i + 1, parts, samples, passes)) + " file=" + partName(i) + " ;;\n";
    names += " " + partName(i);
  }
  writeScript(folder / "part.sh",
              "#!/bin/sh\n"
              "# part.sh N: renders part N, or goes on with it.\n" +
                  recurse + "cd " + in + " || exit 1\ncase \"$1\" in\n" + ranges +
                  "*) echo \"there is no part '$1'\" >&2; exit 2 ;;\nesac\n" + "exec \"$RECURSE\" render " +
                  settings + " --sample-range $range --checkpoint $file --resume --progress plain\n");
  writeScript(
      folder / "merge.sh",
      "#!/bin/sh\n# merge.sh [OPTION...]: the picture, once all parts are there; with --partial, of what "
      "there is.\n" +
          recurse + "cd " + in + " || exit 1\nexec \"$RECURSE\" merge" + names +
          " -o picture.exr -o picture.png \"$@\"\n");
  writeScript(folder / "local.sh",
              "#!/bin/sh\n# All parts one after the other, then the picture. Parts that "
              "failed are run again by the next call.\n" +
                  ("part=0\nwhile [ $part -lt " + std::to_string(parts)) + " ]; do\n  " + in +
                  "/part.sh $part || echo \"part $part failed\" >&2\n  part=$((part + 1))\n"
                  "done\nexec " +
                  in + "/merge.sh\n");
  // A job that is cancelled or requeued gets SIGTERM, and writes what it has.
  writeScript(folder / "slurm.sh", "#!/bin/sh\n"
                                   "# sbatch slurm.sh; then: sbatch --dependency=afterany:JOB merge.sh\n"
                                   "#SBATCH --job-name=recurse\n"
                                   "#SBATCH --array=0-" +
                                       std::to_string(parts - 1) +
                                       "\n"
                                       "#SBATCH --requeue\n"
                                       "#SBATCH --output=" +
                                       (folder / "slurm-%A_%a.log").string() + "\n" + "exec " + in +
                                       "/part.sh \"$SLURM_ARRAY_TASK_ID\"\n");
  if (!o.render.quiet)
    std::fputs((folder.string() + ": " + std::to_string(parts) + " parts of about " +
                formatted("%.4g", double(samples) / double(parts)) +
                " samples per pixel; run slurm.sh with sbatch, or local.sh, then merge.sh\n")
                   .c_str(),
               stderr);
  return ExitStatus::DONE;
}

} // namespace

void addSplitCommand(CLI::App& app, Command& chosen) {
  auto options = std::make_shared<SplitOptions>();
  SplitOptions& o = *options;
  CLI::App* command = app.add_subcommand("split", "Write scripts that render a scene in many jobs");
  o.render.addSceneTo(*command);
  command->add_option("--parts", o.parts, "How many jobs")->required()->type_name("N");
  command->add_option("-o,--output", o.folder, "Folder for the scripts, the parts and the picture")
      ->required()
      ->type_name("FOLDER");
  command
      ->add_option("--paths", o.paths,
                   "Only light paths of this class, such as 'LS+DE'; see 'recurse classes'")
      ->type_name("EXPR");
  o.render.addTo(*command);
  command->footer(
      "Writes part.sh, which renders one part; slurm.sh, an array of jobs for Slurm; local.sh, all parts in\n"
      "turn; merge.sh, which adds them up to picture.exr and picture.png, and says what is missing. A part\n"
      "that was killed goes on where its checkpoint stands when it is run again. The picture has the same "
      "bits\n"
      "as that of one render. RECURSE=FILE in the environment is the program to run.\n\n"
      "Examples:\n"
      "  recurse split scene.pbrt --parts 64 --spp 4096 -o job\n"
      "  sbatch job/slurm.sh\n"
      "  job/merge.sh --partial --exposure 1");
  command->callback([options, &chosen] { chosen = [options] { return splitRender(*options); }; });
}

} // namespace recurse::apps
