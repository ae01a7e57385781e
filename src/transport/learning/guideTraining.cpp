/** @file
 * Records of training camera paths, from which the guide is built.
 */
#include "transport/learning/guideTraining.h"

#include <cmath>

#include "transport/direct/cameraPaths.h"
#include "transport/direct/directLight.h"
#include "transport/forward/photonGuidance.h"
#include "transport/forward/shoot.h"

namespace recurse {

namespace {

using Records = std::vector<GuideRecord>;

/** Training paths of a row of the film. */
struct TrainingRow {
  Records records;
  double guided = 0, plain = 0; ///< sums of squared luminance, as found and as expected without a guide
};

/** Converts a camera path to records, one for each vertex left by a non-delta lobe: the light that the path
 * finds beyond the vertex, times the MIS weights with which the render would add it. */
class TrainingPath {
 public:
  explicit TrainingPath(TrainingRow& row) : row(row) {}

  /** Adds radiance that the path has found, multiplied by its throughput. */
  void add(const Rgb& radiance) {
    const float found = luminance(radiance);
    for (Vertex& v : vertices) v.found += found;
    guided += found;
    plain += found * densityRatio;
  }
  /** Begins a record at a vertex that the path leaves. Its throughput is the one on arrival. */
  void leave(const CameraVertex& vertex, const Scatter& s) {
    constexpr size_t MAX_VERTICES = 32;
    float pdf, plainPdf; // density of the direction, and without a guide
    GuideRecord r;
    r.position = vertex.point().position;
    r.direction = s.direction;
    if (vertex.medium) {
      plainPdf = vertex.phase(s.direction);
      pdf = static_cast<float>(vertex.pdfDirection(s.direction));
    } else {
      r.normal = vertex.point().normalTowards(vertex.wi);
      plainPdf = vertex.scattering->pdfBsdf(vertex.wi, s.direction);
      pdf = vertex.scattering->pdfNonDelta(vertex.wi, s.direction);
    }
    if (!(plainPdf > 0)) return;
    densityRatio *= pdf / plainPdf;
    const float before = luminance(vertex.throughput);
    if (vertices.size() < MAX_VERTICES && before > 0) vertices.push_back({r, before});
  }
  void finish() {
    for (Vertex& v : vertices) {
      v.record.value = v.found / v.throughput;
      if (v.record.value > 0 && std::isfinite(v.record.value)) row.records.push_back(v.record);
    }
    const double expected = square(double(plain)) / double(densityRatio); // importance sampling
    if (!std::isfinite(expected)) return;
    row.guided += square(double(guided));
    row.plain += expected;
  }

 private:
  struct Vertex {
    GuideRecord record;
    float throughput; ///< luminance of the throughput before the vertex
    float found = 0;  ///< luminance at the camera of the light found beyond
  };
  TrainingRow& row;
  std::vector<Vertex> vertices;
  float densityRatio = 1;      ///< density of the path's directions over that without a guide
  float guided = 0, plain = 0; ///< luminance found, and the same path's luminance without a guide
};

std::vector<TrainingRow> trainingRows(const Scene& scene, const LightSampler& lights, const GuideField& guide,
                                      const GuideTrainingSettings& settings, int resolution, uint64_t seed,
                                      const ForwardControl& control, TransportCounts& counts) {
  const PathClasses classes;
  const auto follow = [&](TrainingRow& row, CameraSubpath& path, CameraWalker& walker, Sampler& sampler,
                          TransportCounts& rowCounts) {
    if (control.stopped()) return;
    if (scene.hasMedia()) path.hero = drawHero(sampler.next1D());
    TrainingPath recorder(row);
    PathRadiance direct(classes, rowCounts);
    CameraVertex vertex;
    BsdfRay last;
    const auto emission = [&](const Hit* hit) {
      forLightHits(scene, lights, hit, path.ray, last, settings.lightSamples,
                   scene.hasMedia() ? &path : nullptr,
                   [&](const LightHit& found) { recorder.add(path.throughput * found.weighted); });
    };
    const auto mediumEmission = [&](const Rgb& radiance) { recorder.add(radiance); };
    while (walker.next(path, vertex, sampler, emission, mediumEmission)) {
      followGuide(guide, vertex);
      LightSampleContext context;
      if (vertex.isConnectable()) {
        context = lightSampleContext(lights, vertex);
        direct.reset();
        addDirectLight(scene, lights, context, path, vertex, settings.lightSamples,
                       panesLeft(settings.maxDepth, vertex.depth), sampler, direct);
        recorder.add(direct.total());
      }
      const std::optional<Scatter> s = walker.scatter(path, vertex, sampler);
      if (!s) break;
      if (!path.delta && (vertex.medium || vertex.scattering->isGuidable())) recorder.leave(vertex, *s);
      if (vertex.medium || !passesPane(scene, *vertex.scattering, *s))
        last = {context, static_cast<float>(path.pdf), !path.delta};
    }
    recorder.finish();
  };
  return followCameraPaths(scene, resolution, settings.maxDepth, seed, counts, TrainingRow(), follow,
                           InMedia::SCATTER);
}

/** See GuideStatistics. */
double gainOf(const std::vector<TrainingRow>& rows) {
  double sum = 0;
  for (const TrainingRow& row : rows)
    if (row.guided > 0 && row.plain > 0) sum += std::log(row.plain / row.guided);
  return std::exp(sum / double(rows.size()));
}

} // namespace

std::vector<GuideRecord> photonRecords(const Scene& scene, const Pass& pass, const ShootSettings& shoot,
                                       const ForwardControl& control, TransportCounts& counts) {
  const PathClasses allPaths;
  ForwardControl local;
  local.stop = control.stop;
  const ShotPhotons shot = shootPhotons(scene, allPaths, pass, shoot, local);
  counts.add(shot.counts);
  std::vector<GuideRecord> records;
  for (const Photon& p : shot.onSurfaces) {
    // reverseRatio 0: no ray can hit this light; skip its caustic photons.
    if (p.caustic && !(p.reverseRatio > 0)) continue;
    GuideRecord r;
    r.position = p.position;
    r.normal = unpackDirection(p.normal);
    r.direction = unpackDirection(p.direction);
    r.value = luminance(p.power);
    r.fromPhoton = true;
    if (r.value > 0 && std::isfinite(r.value) && glm::dot(r.direction, r.normal) > 0) records.push_back(r);
  }
  for (const VolumePhoton& p : shot.inMedia) {
    GuideRecord r;
    r.position = p.position;
    r.direction = -unpackDirection(p.direction);
    r.value = luminance(p.power);
    r.fromPhoton = true;
    if (r.value > 0 && std::isfinite(r.value)) records.push_back(r);
  }
  return records;
}

std::vector<GuideRecord> GuideTraining::photonsOfStage(const Scene& scene, const Pass& pass, double count,
                                                       const ForwardControl& control,
                                                       TransportCounts& counts) {
  constexpr uint64_t TRIALS = 8192; // photons per round of emission learning
  const PathClasses allPaths;
  if (stage < 0)
    emission = learnEmission(scene, allPaths, pass.seed, settings.maxDepth, control, counts, TRIALS);
  ShootSettings shoot;
  shoot.photons = static_cast<uint64_t>(count);
  shoot.maxDepth = settings.maxDepth;
  shoot.direct = false;
  shoot.emission.mixture = &emission;
  return photonRecords(scene, pass, shoot, control, counts);
}

void GuideTraining::prepare(const Scene& scene, const LightSampler& lights, const Pass& pass,
                            const ForwardControl& control, TransportCounts& counts) {
  constexpr uint64_t STREAM = 0x6775696465ull;
  constexpr double PATHS = 1.0 / 16, MIN_PATHS = 4096; // fraction of the paths in all passes before
  constexpr size_t MAX_RECORDS = 200'000;              // 10 MB; more records improve no scene tried
  constexpr float FOOTPRINTS = 4;                      // smallest extent of a cell [pixels]
  constexpr int TRIAL = 2;                             // last stage of a guide that gains little
  // Ratios of the processor times of guided and plain paths. The first is the mean of seven scenes without
  // media, where plain paths are traced in batches and are faster.
  constexpr double TIME_RATIO = 1.7, TIME_RATIO_IN_MEDIA = 1.3;
  if (pass.index == 0) {
    stage = -1;
    records.clear();
    field = {};
    isFollowed = false;
    emission = {};
  }
  const double timeRatio = scene.hasMedia() ? TIME_RATIO_IN_MEDIA : TIME_RATIO;
  // Later stages gain more: one that has half of the gain that is needed (in logarithm) is trained further.
  const auto isPromising = [&] { return stage < TRIAL || gain > std::sqrt(timeRatio); };
  const PixelBounds film = scene.film().whole();
  const float smallest =
      FOOTPRINTS * scene.bounds().radius / static_cast<float>(std::max(film.width(), film.height()));
  const int last = static_cast<int>(pass.index) - 1;
  while (stage < last && records.size() < MAX_RECORDS && isPromising()) {
    Pass training = pass;
    training.index = static_cast<uint32_t>(stage + 1);
    training.seed = hashCombine(pass.seed, STREAM + training.index);
    if (scene.moves()) training.time = scene.camera().timeAt(Sampler(training.seed, STREAM, 0).next1D());
    const double paths = std::max(MIN_PATHS, PATHS * double(film.area()) * std::exp2(stage + 1));
    const Records photons = photonsOfStage(scene, training, paths, control, counts);
    GuideField byPhotons;
    if (stage < 0) byPhotons.build(photons, smallest);
    const auto resolution = static_cast<int>(std::sqrt(paths));
    const std::vector<TrainingRow> rows = trainingRows(scene, lights, stage < 0 ? byPhotons : field, settings,
                                                       resolution, training.seed, control, counts);
    if (control.stopped()) return;
    gain = gainOf(rows);
    isFollowed = gain > timeRatio;
    records.insert(records.end(), photons.begin(), photons.end());
    for (const TrainingRow& row : rows) records.insert(records.end(), row.records.begin(), row.records.end());
    field.build(records, smallest);
    ++stage;
  }
}

std::optional<GuideStatistics> GuideTraining::statistics() const {
  if (stage < 0) return {};
  GuideStatistics out = field.statistics();
  if (!isFollowed) out.cellsOn = 0;
  out.gain = gain;
  return out;
}

} // namespace recurse
