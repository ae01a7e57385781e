/** @file
 * Import of Quake III maps from their archives: surfaces with pictures and shader scripts, lights, sun and
 * sky, and the spawn points of players as cameras. Light in the units of the map compiler (q3map, 2005) is
 * converted to physical units by the display of the game: lightmap value 64 shows a texture in its own
 * colour, which corresponds to an irradiance of pi.
 */
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>

#include "importers/quake3/gameFiles.h"
#include "importers/quake3/gameShader.h"
#include "importers/quake3/quake3Bsp.h"
#include "importers/quake3/quake3Pictures.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

constexpr double MAP_PI = 3.14159265358979323846;
/** Irradiance of a lightmap value of 1. */
constexpr double IRRADIANCE_UNIT = MAP_PI / 64;
/** Factors of q3map from a light entity's value to intensity, and from a surfacelight's value to radiance.
 */
constexpr double POINT_SCALE = 7500, AREA_SCALE = 0.25;
constexpr double DEFAULT_LIGHT = 300, DEFAULT_RADIUS = 64, CONE_MARGIN = 16;
/** Height of a player's eyes above the origin of the entity [map units]. */
constexpr double EYE_HEIGHT = 26;
/** Largest distance of a triangle from a curved surface [map units]; the game itself takes 4. */
constexpr double PATCH_TOLERANCE = 0.1;
constexpr int MOST_PATCH_STEPS = 32;

class Quake3Import {
 public:
  Quake3Import(const Parameters& p, const ImportContext& context, SceneImport& import)
      : p(p), import(import), out(import, context), game(pathsOf(p)), pictures(p, game, import, out),
        metre(p.real("unitspermetre")), lightScale(p.real("lightscale")) {}

  void run() {
    import.filesRead = game.paths();
    import.up = {0, 0, 1};
    import.front = {1, 0, 0};
    import.isInterior = true;
    const std::string mapName = chooseMap();
    map = readQuake3Bsp(game.where(mapName), game.read(mapName));
    readScripts();
    addFaces();
    if (triangles == 0) p.fail("pak", game.where(mapName) + " has no visible surface");
    warnOfMissingPictures();
    addSky();
    addEntities();
    note(mapName);
  }

 private:
  // ---- files of the game

  /** Paths of the archives, relative to the file that names them. */
  static std::vector<std::string> pathsOf(const Parameters& p) {
    const std::vector<std::string> names = p.strings("pak");
    if (names.size() == 1) return {p.filePath("pak")};
    std::vector<std::string> paths;
    for (const std::string& name : names) {
      const std::filesystem::path path = std::filesystem::path(p.directory()) / name;
      if (!std::filesystem::is_regular_file(path))
        p.fail("pak", "there is no file \"" + name + "\"", "an existing file; tried " + path.string());
      paths.push_back(path.string());
    }
    return paths;
  }

  static std::string mapTitle(const std::string& name) { return name.substr(5, name.size() - 9); }

  /** Name of the requested map, or of the only map in the last archive that has any. */
  std::string chooseMap() const {
    const std::vector<std::string> maps = game.list("maps/", ".bsp");
    if (maps.empty()) p.fail("pak", game.paths().back() + " has no map", "an archive with maps/NAME.bsp");
    std::string list, names;
    size_t count = 0;
    for (const std::string& name : maps) {
      list += (list.empty() ? "" : ", ") + mapTitle(name);
      count += game.sourceOf(name) == game.sourceOf(maps[0]);
    }
    if (!p.has("map")) {
      if (count == 1) return maps[0];
      p.fail("pak", game.paths()[game.sourceOf(maps[0])] + " has several maps",
             "\"string map\", or --map, of: " + list);
    }
    for (const std::string& spelling :
         {"maps/" + p.string("map") + ".bsp", "maps/" + p.string("map"), p.string("map")})
      if (const auto found = std::find(maps.begin(), maps.end(), ZipArchive::normalised(spelling));
          found != maps.end())
        return *found;
    p.fail("map", game.paths().back() + " has no map \"" + p.string("map") + "\"", list);
  }

  void readScripts() {
    for (const std::string& name : game.list("scripts/", ".shader")) {
      std::vector<std::string> warnings;
      readGameShaders(game.where(name), game.read(name), scripts, warnings);
      for (const std::string& w : warnings) p.warn("pak", w);
    }
  }

  void warnOfMissingPictures() const {
    constexpr size_t MOST = 5;
    if (missing.empty()) return;
    std::string names;
    for (size_t i = 0; i < missing.size() && i < MOST; ++i) names += (i ? ", \"" : "\"") + missing[i] + "\"";
    p.warn("pak",
           missing.size() == 1
               ? "there is no picture for " + names + "; a checkerboard replaces it"
               : "there are no pictures for " + std::to_string(missing.size()) + " textures: " + names +
                     (missing.size() > MOST ? ", ...; checkerboards replace them"
                                            : "; checkerboards replace them"),
           "all archives of the game: \"string pak\" [ \"pictures.pk3\" \"map.pk3\" ]");
  }

  // ---- surfaces

  struct Look {
    bool made = false, isDrawn = true, emits = false;
    std::string directives, shapeParameters;
  };

  const GameShader* scriptOf(const std::string& name) const {
    const auto found = scripts.find(gameShaderName(name));
    return found == scripts.end() ? nullptr : &found->second;
  }

  void addFaces() {
    const int steps = patchSteps(map, PATCH_TOLERANCE, MOST_PATCH_STEPS);
    looks.resize(map.shaders.size());
    std::map<uint32_t, MeshData> byShader;
    for (Quake3Bsp::Face& face : map.faces) {
      const Look& look = lookOf(face.shader);
      if (!look.isDrawn) continue;
      if (face.patchWidth > 0) {
        tessellatePatch(face, steps);
        ++patches;
      }
      if (face.triangles.empty()) continue;
      triangles += face.triangles.size();
      if (look.emits) { // one lamp per face, so that nearby ones can be sampled
        MeshData alone;
        append(face, alone);
        emitShape(face.shader, alone);
        ++lamps;
      } else {
        append(face, byShader[face.shader]);
      }
      face = {}; // releases its memory
    }
    for (const auto& [shader, mesh] : byShader) emitShape(shader, mesh);
  }

  void append(const Quake3Bsp::Face& face, MeshData& mesh) const {
    const auto first = static_cast<uint32_t>(mesh.positions.size());
    for (const Quake3Bsp::Vertex& v : face.vertices) {
      mesh.positions.push_back(v.position / metre);
      mesh.normals.push_back(v.normal);
      mesh.uvs.push_back(v.uv);
    }
    for (const glm::uvec3& t : face.triangles) mesh.triangles.push_back(t + first);
  }

  void emitShape(uint32_t shader, const MeshData& mesh) {
    const Look& look = looks[shader];
    const std::string name = gameShaderName(map.shaders[shader].name);
    const std::string shape =
        out.meshShape(name.substr(name.rfind('/') + 1), mesh, Mat4d(1), look.shapeParameters);
    out.line("AttributeBegin\n" + look.directives + shape + "\nAttributeEnd");
  }

  const Look& lookOf(uint32_t shader) {
    Look& look = looks[shader];
    if (!look.made) {
      look.made = true;
      makeLook(map.shaders[shader], look);
    }
    return look;
  }

  void makeLook(const Quake3Bsp::ShaderReference& reference, Look& look) {
    const GameShader* script = scriptOf(reference.name);
    if (reference.isSky || (script && script->isSky)) {
      look.isDrawn = false;
      if (!sky) sky = script;
      return;
    }
    if (reference.isInvisible || (script && script->isInvisible)) {
      look.isDrawn = false;
      return;
    }
    const GameShader::Stage* base = script ? script->base() : nullptr;
    std::string file = pictures.find(base ? base->image : reference.name);
    if (file.empty() && script) file = pictures.find(reference.name);
    if (file.empty() && script) file = pictures.find(script->editorImage);
    if (script && script->isLiquid) {
      look.directives = "Material \"dielectric\" \"float eta\" 1.33\n";
      return;
    }
    const bool additive = base && base->isAdditive();
    if (file.empty()) {
      missing.push_back(reference.name);
      look.directives =
          "Material \"diffuse\" \"texture reflectance\" " + sceneText(out.missingTexture()) + "\n";
    } else if (additive) { // adds to the light from behind, and absorbs none
      look.directives = "Material \"diffuse\" \"rgb reflectance\" [ 0 0 0 ]\n";
      look.shapeParameters =
          "\"texture alpha\" " + sceneText(out.imageTexture("float", file, "\"string encoding\" \"linear\""));
    } else {
      look.directives = "Material \"diffuse\" \"texture reflectance\" " +
                        sceneText(out.imageTexture("spectrum", file)) + "\n";
      readAlpha(base, file, look);
    }
    const double value = script ? script->surfaceLight : 0;
    if (value > 0 || (additive && !file.empty())) {
      look.emits = true;
      look.directives += emission(*script, file, additive, value);
    }
  }

  void readAlpha(const GameShader::Stage* base, const std::string& file, Look& look) {
    if (!base || !(base->alphaThreshold || base->isBlended()) || pictures.image(file).channel("A") < 0)
      return;
    std::string more = "\"string channel\" \"alpha\" \"string encoding\" \"linear\"";
    if (base->alphaThreshold) {
      const double threshold = double(*base->alphaThreshold);
      more += base->showsLowAlpha ? " \"bool invert\" true \"float threshold\" " + sceneText(1 - threshold)
                                  : " \"float threshold\" " + sceneText(threshold);
    }
    look.shapeParameters = "\"texture alpha\" " + sceneText(out.imageTexture("float", file, more));
  }

  /** Emission whose mean is q3map's constant colour: in the pattern of the picture, or uniform where the
   * picture is already the opacity of the surface. */
  std::string emission(const GameShader& script, const std::string& file, bool additive, double value) {
    const double radiance = value > 0 ? value * AREA_SCALE * IRRADIANCE_UNIT * lightScale : lightScale;
    std::string light = "AreaLightSource \"diffuse\" ";
    if (!additive && !file.empty() && pictures.meanMaximum(file) > 0) {
      light += "\"string filename\" " + sceneText(file) + " \"string wrap\" \"repeat\" \"float scale\" " +
               sceneText(radiance / pictures.meanMaximum(file));
    } else {
      const std::string colourFile = pictures.find(script.lightImage);
      double opacity = 1;
      if (additive && value > 0 && !file.empty()) opacity = pictures.meanOpacity(file);
      light += "\"rgb L\" [ " +
               sceneText(Vec3d(pictures.lightColour(colourFile.empty() ? file : colourFile) *
                               (radiance / opacity))) +
               " ]";
    }
    return light + (script.isTwoSided ? " \"bool twosided\" true\n" : "\n");
  }

  // ---- light that is not on surfaces

  void addSky() {
    if (!sky) return;
    const GameShader::Stage* base = sky->base();
    std::string file = pictures.find(sky->lightImage);
    if (file.empty() && base) file = pictures.find(base->image);
    if (file.empty()) file = pictures.find(sky->editorImage);
    if (sky->surfaceLight > 0) {
      const Rgbd radiance =
          pictures.lightColour(file) * (sky->surfaceLight * AREA_SCALE * IRRADIANCE_UNIT * lightScale);
      out.line("LightSource \"infinite\" \"rgb L\" [ " + sceneText(Vec3d(radiance)) + " ]");
      import.taken.push_back("sky");
      import.hasLights = true;
    }
    if (!sky->skyBox.empty()) import.leftOut.push_back("pictures of the sky");
    if (!sky->sun || !(sky->sun->intensity > 0) || !(glm::length(sky->sun->colour) > 0)) return;
    const GameShader::Sun& sun = *sky->sun;
    const double azimuth = glm::radians(sun.azimuth), elevation = glm::radians(sun.elevation);
    const Vec3d from(std::cos(azimuth) * std::cos(elevation), std::sin(azimuth) * std::cos(elevation),
                     std::sin(elevation));
    const Vec3d irradiance = glm::normalize(sun.colour) * (sun.intensity * IRRADIANCE_UNIT * lightScale);
    out.line("LightSource \"distant\" \"rgb L\" [ " + sceneText(irradiance) + " ] \"point3 from\" [ " +
             sceneText(from) + " ] \"point3 to\" [ 0 0 0 ]");
    import.taken.push_back("sun");
    import.hasLights = true;
  }

  void addEntities() {
    std::map<std::string, Vec3d> targets;
    for (const Quake3Bsp::Entity& e : map.entities)
      if (const auto origin = vectorOf(e, "origin"); origin && e.contains("targetname"))
        targets.try_emplace(valueOf(e, "targetname"), *origin);
    int spawns = 0, intermissions = 0;
    for (const Quake3Bsp::Entity& e : map.entities) {
      const std::string kind = valueOf(e, "classname");
      const auto origin = vectorOf(e, "origin");
      if (!origin) continue;
      if (kind.starts_with("light") && kind != "lightJunior") {
        addLight(e, *origin, targets);
      } else if (kind == "info_player_deathmatch" || kind == "info_player_start") {
        const double yaw = glm::radians(numberOf(e, "angle", 0));
        addCamera("spawn " + std::to_string(++spawns), *origin + Vec3d(0, 0, EYE_HEIGHT),
                  {std::cos(yaw), std::sin(yaw), 0});
      } else if (kind == "info_player_intermission") {
        const auto target = targets.find(valueOf(e, "target"));
        const double yaw = glm::radians(numberOf(e, "angle", 0));
        const Vec3d ahead =
            target == targets.end() ? Vec3d(std::cos(yaw), std::sin(yaw), 0) : target->second - *origin;
        const std::string number = ++intermissions > 1 ? " " + std::to_string(intermissions) : "";
        addCamera("intermission" + number, *origin, ahead);
      }
    }
  }

  void addLight(const Quake3Bsp::Entity& e, const Vec3d& origin,
                const std::map<std::string, Vec3d>& targets) {
    double value = numberOf(e, "light", numberOf(e, "_light", DEFAULT_LIGHT));
    if (value == 0) value = DEFAULT_LIGHT;
    if (!(value > 0)) { // negative ones darken the map
      ++dark;
      return;
    }
    Vec3d colour = glm::max(vectorOf(e, "_color").value_or(Vec3d(1)), Vec3d(0));
    const double largest = std::max({colour.x, colour.y, colour.z});
    colour = largest > 0 ? colour / largest : Vec3d(1);
    const Vec3d intensity = colour * (value * POINT_SCALE * IRRADIANCE_UNIT * lightScale / (metre * metre));
    const std::string place =
        "\"rgb I\" [ " + sceneText(intensity) + " ] \"point3 from\" [ " + sceneText(origin / metre) + " ]";
    import.hasLights = true;
    ++lights;
    const auto target = targets.find(valueOf(e, "target"));
    const double distance = target == targets.end() ? 0 : glm::length(target->second - origin);
    if (!(distance > 0)) {
      out.line("LightSource \"point\" " + place);
      return;
    }
    const double radius = std::abs(numberOf(e, "radius", DEFAULT_RADIUS));
    const double outer = glm::degrees(std::atan((radius + CONE_MARGIN) / distance));
    const double inner = glm::degrees(std::atan(std::max(radius - CONE_MARGIN, 0.0) / distance));
    out.line("LightSource \"spot\" " + place + " \"point3 to\" [ " + sceneText(target->second / metre) +
             " ] \"float coneangle\" " + sceneText(std::max(outer, 0.001)) + " \"float conedeltaangle\" " +
             sceneText(outer - inner));
  }

  void addCamera(const std::string& name, const Vec3d& eye, const Vec3d& ahead) {
    const Vec3d right = glm::cross(ahead, Vec3d(0, 0, 1));
    if (!(glm::length(right) > 0)) return;
    ImportedCamera camera;
    camera.name = name;
    camera.fov = 73.7; // 90 degrees across a picture of 4:3
    camera.worldFromCamera[0] = Vec4d(glm::normalize(right), 0);
    camera.worldFromCamera[1] = Vec4d(glm::normalize(glm::cross(right, ahead)), 0);
    camera.worldFromCamera[2] = Vec4d(glm::normalize(ahead), 0);
    camera.worldFromCamera[3] = Vec4d(eye / metre, 1);
    import.cameras.push_back(camera);
  }

  void note(const std::string& mapName) {
    const auto add = [](std::vector<std::string>& list, size_t count, const std::string& what) {
      if (count > 0) list.push_back(std::to_string(count) + " " + what);
    };
    import.taken.insert(import.taken.begin(), mapName);
    add(import.taken, triangles, "triangles");
    add(import.taken, patches, "curved patches");
    add(import.taken, import.files.size(), "files");
    add(import.taken, lamps, "emitting faces");
    add(import.taken, lights, "lights");
    for (const ImportedCamera& camera : import.cameras)
      import.taken.push_back("camera \"" + camera.name + "\"");
    add(import.leftOut, dark, "lights with negative intensity");
    if (!map.entities.empty() && numberOf(map.entities[0], "ambient", 0) > 0)
      import.leftOut.push_back("the ambient light of the map compiler");
  }

  const Parameters& p;
  SceneImport& import;
  ImportWriter out;
  GameFiles game;
  Quake3Pictures pictures;
  double metre;      ///< map units per metre
  double lightScale; ///< factor of all light
  Quake3Bsp map;
  GameShaders scripts;
  std::vector<std::string> missing; ///< textures without a picture
  std::vector<Look> looks;          ///< looks by shader of the map
  const GameShader* sky = nullptr;
  size_t triangles = 0, patches = 0, lamps = 0, lights = 0, dark = 0;
};

} // namespace

void registerQuake3Map(PlugIns& plugIns) {
  plugIns.imports.add(
      {{.name = "quake3map",
        .summary = "A map of Quake III with its lights, from its .pk3 archive or as a file; +z is up. "
                   "Cameras are \"spawn 1\" and so on, and \"intermission\".",
        .parameters =
            {arrayParameter(
                 ParameterType::STRING, "pak", 0, "",
                 "one or more archives, of which later ones have precedence as in the game; or a map (.bsp). "
                 "If the map is in a folder \"maps\", the files in the folders beside it are used as well")
                 .require(),
             stringParameter("map", "",
                             "name of the map; not needed if the last archive with maps has only one"),
             realParameter("unitspermetre", "40", "map units in one scene unit").positive(),
             realParameter("lightscale", "1", "factor on all light of the map").positive()},
        .examples = {}},
       [](const Parameters& p, const ImportContext& context) {
         auto import = std::make_unique<SceneImport>();
         try {
           Quake3Import(p, context, *import).run();
         } catch (const SceneError&) {
           throw;
         } catch (const Error& e) {
           p.fail("pak", e.what());
         }
         return import;
       }});
}

} // namespace recurse
