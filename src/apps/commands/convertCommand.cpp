/** @file
 * `recurse convert`: conversion of a model to a self-contained scene.
 */
#include <filesystem>

#include "apps/commands/commands.h"
#include "apps/load/modelScene.h"
#include "apps/run/outputFiles.h"
#include "recurse/core/image/image.h"
#include "recurse/core/io/atomicFile.h"

namespace recurse::apps {

namespace {

namespace fs = std::filesystem;

ExitStatus convert(const std::string& input, const ModelChoice& choice, const std::string& output,
                   bool allowsOutside) {
  if (!isModelFile(input))
    throw Error(input + ": has no known extension of a model; accepted are .gltf .glb .obj .dae .fbx .stl "
                        ".3ds .ply .md2 .pk3 .bsp and more",
                ExitStatus::BAD_USAGE);
  if (!output.ends_with(".pbrt"))
    throw Error("-o: " + output + " does not end in .pbrt", ExitStatus::BAD_USAGE);
  checkFileWritable(output);
  const std::string stem = fs::path(output).stem().string();
  if (sceneText(stem) != '"' + stem + '"')
    throw Error("-o: scene files cannot name files with quotes, backslashes or control characters: " + output,
                ExitStatus::BAD_USAGE);
  Diagnostics diagnostics;
  const std::string folder = stem + "-files/";
  const std::unique_ptr<ModelScene> scene =
      modelScene(input, choice, folder, allowsOutside ? "warn" : "refuse", diagnostics);
  diagnostics.throwIfErrors();
  say(diagnostics.format());
  const fs::path base = fs::path(output).parent_path();
  std::vector<OutputFile> written = {{"-o", output}};
  for (const auto& [name, content] : *scene->files) written.push_back({"-o", (base / name).string()});
  requireDistinctFiles(written, inputFiles("a file of the model", scene->filesRead));
  std::error_code error;
  if (!scene->files->empty()) fs::create_directories(base / folder, error);
  if (error) throw Error((base / folder).string() + ": the folder cannot be created: " + error.message());
  for (const auto& [name, content] : *scene->files) writeFileAtomically((base / name).string(), *content);
  writeFileAtomically(output, scene->text);
  say(output + ": " + scene->note + "\n");
  return ExitStatus::DONE;
}

} // namespace

void addConvertCommand(CLI::App& app, Command& chosen) {
  auto input = std::make_shared<std::string>();
  auto output = std::make_shared<std::string>();
  auto allowsOutside = std::make_shared<bool>(false);
  auto choice = std::make_shared<ModelChoice>();
  CLI::App* command = app.add_subcommand(
      "convert", "Convert a model to a scene file with camera, light, meshes and pictures");
  command
      ->add_option("model", *input,
                   "The model: .gltf .glb .obj .dae .fbx .stl .3ds .ply .md2 .pk3 .bsp and more")
      ->required()
      ->type_name("FILE");
  command
      ->add_option("-o,--output", *output,
                   "Scene file to write, .pbrt; meshes and pictures are written to a folder beside it")
      ->required()
      ->type_name("FILE");
  command->add_flag("--allow-outside", *allowsOutside,
                    "Copy pictures and other files that the model names outside of its own folder, each with "
                    "a warning; without this option they are left out");
  choice->addTo(*command);
  command->footer(
      "The scene has the model's camera, or a camera that sees all of it; and the model's lights, or a sky\n"
      "and a sun. 'recurse render' accepts a model as well, without a scene file.\n\n"
      "Examples:\n"
      "  recurse convert model.gltf -o scene.pbrt\n"
      "  recurse render model.gltf -o model.png");
  command->callback(
      [=, &chosen] { chosen = [=] { return convert(*input, *choice, *output, *allowsOutside); }; });
}

} // namespace recurse::apps
