/** @file
 * auto: photon mapping, path tracing, or path tracing with caustic photons, chosen by a trial on a few blocks
 * of the image.
 */
#include "integrators/auto/estimatorTrial.h"
#include "integrators/path/pathTracing.h"
#include "integrators/photonmap/photonMapping.h"
#include "recurse/core/io/text.h"
#include "recurse/core/threads/processorTime.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

class Auto final : public Integrator {
 public:
  explicit Auto(const PhotonMappingSettings& settings)
      : settings(settings), mapper(std::make_unique<PhotonMapping>(settings)) {}

  Passes passes(int samplesPerPixel) const override { return mapper->passes(samplesPerPixel); }
  uint64_t photonsEmitted(const Scene& scene) const override { return mapper->photonsEmitted(scene); }
  bool passHasOneTime() const override { return true; }
  bool supportsMedia(const Scene& scene) const override { return mapper->supportsMedia(scene); }
  bool supportsTransient(const Scene& scene) const override { return mapper->supportsTransient(scene); }
  std::string choices() const override {
    return "photonmap; path; or path with caustic photons (photonmap with \"bool causticsonly\" true)";
  }
  std::vector<EstimatorDomain> domains() const override { return chosen().domains(); }

  TransportCounts prepare(const Scene& scene, const PathClasses& classes) override {
    return mapper->prepare(scene, classes);
  }
  ForwardStatistics forward(const Scene& scene, const PathClasses& classes, const Pass& pass,
                            const ForwardControl& control) override {
    if (pass.index == 0) instead.reset();
    ForwardStatistics statistics = chosen().forward(scene, classes, pass, control);
    if (pass.index == 0) {
      const ProcessorTimer timer(statistics.learningSeconds);
      choose(scene, classes, pass, control, statistics);
    }
    return statistics;
  }
  void backward(const Scene& scene, const CameraRay& ray, Sampler& sampler,
                PathRadiance& out) const override {
    chosen().backward(scene, ray, sampler, out);
  }
  void backwardBatch(const Scene& scene, std::span<CameraPath> paths) const override {
    chosen().backwardBatch(scene, paths);
  }
  void visitPhotons(const std::function<void(const StoredPhoton&)>& visit) const override {
    chosen().visitPhotons(visit);
  }
  std::string photonPaths() const override { return chosen().photonPaths(); }
  void visitPhotonBoxes(int levels, const std::function<void(const PhotonBox&)>& visit) const override {
    chosen().visitPhotonBoxes(levels, visit);
  }

 private:
  Integrator& chosen() const { return instead ? *instead : *mapper; }

  /** Chooses the estimator after the first pass of photonmap, and notes the choice. */
  void choose(const Scene& scene, const PathClasses& classes, const Pass& pass, const ForwardControl& control,
              ForwardStatistics& statistics) {
    if (const std::string reason = reasonForPhotons(scene, pass); !reason.empty())
      statistics.notes.push_back("auto uses photonmap: " + reason);
    else
      tryPaths(scene, classes, pass, control, statistics);
  }

  /** Reason to skip the trial; empty if it costs little beside the render and may change the choice. */
  std::string reasonForPhotons(const Scene& scene, const Pass& pass) const {
    constexpr int MAX_LIGHT_SAMPLES = 64; // with more, a trial may take longer than the render
    if (settings.lightSamples > MAX_LIGHT_SAMPLES)
      return "\"lightsamples\" is above " + std::to_string(MAX_LIGHT_SAMPLES);
    if (settings.finalGather >= 0 || settings.nearest > 0 || settings.radius > 0 || settings.directLight)
      return "parameters of the integrator set the density estimate";
    if (pass.schedule == PassSchedule::ONE_MAP)
      return "a single photon map is requested (\"integer passes\" 1)";
    if (scene.lights().size() == 0) return "the scene has no light";
    if (scene.film().whole().area() < EstimatorTrial::PIXELS)
      return formatted("the picture (below %d pixels) is too small to compare with path tracing",
                       EstimatorTrial::PIXELS);
    if (!mediaOnlyAbsorb(scene) && !raysFindAll(scene))
      return "path tracing does not find all light in the media";
    return {};
  }

  /** Whether rays find all light that photons do. */
  bool raysFindAll(const Scene& scene) const {
    const PhotonPass& photons = mapper->photonPass();
    const bool causticsInMedia = !mediaOnlyAbsorb(scene) && (scene.contents().lobes & DELTA_LOBES);
    if (photons.caustics().map.empty() && !causticsInMedia) return true;
    for (uint32_t i = 0; i < scene.lights().size(); ++i) // rays rarely hit far lights
      if (!scene.lights()[i].isIntersectable() || photons.isFar(i)) return false;
    return true;
  }

  /** Replaces photonmap by path tracing, with or without caustic photons, if a trial on a few blocks of the
   * image shows that all other photons do not repay their work. */
  void tryPaths(const Scene& scene, const PathClasses& classes, const Pass& pass,
                const ForwardControl& control, ForwardStatistics& statistics) {
    // Light through a door ajar is too rare in both for a comparison; photons find it sooner.
    constexpr double FEW = 64; // scenes in which paths are better have hundreds or more
    constexpr uint64_t STREAM = 0x747269616cull;
    const Pass second{hashCombine(pass.seed, STREAM), 1, pass.schedule, pass.time};
    const EstimatorTrial trial(scene, classes, second.seed, pass.time);
    using Rounds = EstimatorTrial::Rounds;
    using Figures = EstimatorTrial::Figures;
    const auto counted = [&](const Rounds& rounds) {
      for (const TrialSamples& samples : rounds) statistics.counts.add(samples.counts);
      return rounds;
    };
    std::unique_ptr<Integrator> paths =
        makePathTracing({settings.maxDepth, settings.lightSamples}, &mapper->lightSampler());
    paths->prepare(scene, classes);
    const Rounds traced = counted({trial.take(*paths, 0), trial.take(*paths, 1)});
    if (control.stopped()) return; // no note on an incomplete trial
    if (EstimatorTrial::effectiveCount(traced) < FEW) {
      statistics.notes.push_back(
          "auto chose photonmap: the trial of path tracing found too few samples with light to compare");
      return;
    }
    Rounds mapped, both; // `both`: paths with caustic photons
    const bool mayShare = !mapper->photonPass().caustics().map.empty() && mediaOnlyAbsorb(scene);
    const auto take = [&](uint32_t round) {
      mapped[round] = trial.take(*mapper, round);
      if (mayShare) mapper->readingCausticsOnly([&] { both[round] = trial.take(*mapper, round); });
    };
    take(0);
    const ForwardStatistics shot = mapper->withPass(second, scene, classes, control, [&] { take(1); });
    statistics.counts.add(shot.counts);
    // Work of a pass for each pixel [camera rays], with storing and sorting.
    const auto photonWork = [&](uint64_t rays) {
      constexpr double PHOTON_RAY = 1.6;
      return PHOTON_RAY * double(rays) / double(scene.film().whole().area());
    };
    Figures byMap = EstimatorTrial::figures(counted(mapped), traced);
    byMap.work += photonWork(shot.counts.rays);
    Figures byPaths = EstimatorTrial::figures(traced, mapped);
    byPaths.add(mapper->photonPass().causticVarianceByRays() +
                EstimatorTrial::missedVariance(traced, mapped));
    bool withCaustics = false;
    if (mayShare) {
      Figures byBoth = EstimatorTrial::figures(counted(both), mapped);
      byBoth.work += photonWork(shot.photonsEmitted); // most have one ray
      byBoth.add(EstimatorTrial::missedVariance(both, mapped));
      withCaustics = !raysFindAll(scene) || byBoth.errorOver(byPaths) < 1;
      if (withCaustics) byPaths = byBoth;
    }
    if (control.stopped() || !arePathsBetter(byMap.errorOver(byPaths), withCaustics, statistics.notes))
      return;
    if (withCaustics) {
      paths = std::make_unique<PhotonMapping>(onlyCaustics(settings), &mapper->lightSampler());
      paths->prepare(scene, classes);
      statistics.counts.add(paths->forward(scene, classes, pass, control).counts);
    }
    instead = std::move(paths);
  }

  /** Whether paths replace photonmap, whose squared error is `ratio` times theirs in the trial; notes the
   * decision. */
  static bool arePathsBetter(double ratio, bool withCaustics, std::vector<std::string>& notes) {
    if (!(ratio > 0)) return false; // neither has found light
    constexpr double CLEARLY = 2;   // trials miss rare bright samples, of which paths have more
    const char* const rival = withCaustics ? "path with caustic photons" : "path";
    notes.push_back(
        formatted("auto chose %s: at equal cost, the squared error of photonmap was %.3g times that of %s",
                  ratio > CLEARLY ? rival : "photonmap", ratio, rival));
    return ratio > CLEARLY;
  }

  PhotonMappingSettings settings;
  std::unique_ptr<PhotonMapping> mapper;
  std::unique_ptr<Integrator> instead; ///< replaces `mapper`; null: photons pay
};

} // namespace

void registerAuto(PlugIns& plugIns) {
  plugIns.integrators.add({{.name = "auto",
                            .summary = "Recurse's default: photonmap, or path where a trial on a few blocks "
                                       "of the picture shows less than half of the squared error for the "
                                       "same work. Scenes with caustics then get a caustic photon map.",
                            .parameters = photonMappingParameters(),
                            .examples = {""}},
                           [](const Parameters& p, const NoContext&) {
                             return std::make_unique<Auto>(photonMappingSettings(p));
                           }});
}

} // namespace recurse
