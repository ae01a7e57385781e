/** @file
 * Lights with a factor on their emission.
 */
#include "model/light/scaledLight.h"

namespace recurse {

namespace {

/** The part that lights of all kinds share. */
template <class Base> class Scaled : public Base {
 public:
  /** `arguments`: those of the constructor of Base. */
  template <class... Arguments>
  Scaled(std::unique_ptr<Base> light, const Rgb& scale, const Arguments&... arguments)
      : Base(arguments...), light(std::move(light)), scale(scale) {}

  LightKind kind() const override { return light->kind(); }
  bool isIntersectable() const override { return light->isIntersectable(); }
  void prepare(const SceneBounds& bounds) override { light->prepare(bounds); }
  Rgb power() const override { return scale * light->power(); }
  std::optional<LeSample> sampleLe(const LeRandom& sample) const override {
    std::optional<LeSample> le = light->sampleLe(sample);
    if (!le) return le;
    le->radiance *= scale;
    le->flux *= scale;
    return le;
  }
  LePdf pdfLe(const LeRay& ray) const override { return light->pdfLe(ray); }
  Rgb radianceTowards(const LeSample& sample, const Vec3f& direction) const override {
    // Some lights derive the result from the sample's radiance, which includes the factor.
    LeSample unscaled = sample;
    for (int c = 0; c < 3; ++c) unscaled.radiance[c] = scale[c] > 0 ? sample.radiance[c] / scale[c] : 0;
    return scale * light->radianceTowards(unscaled, direction);
  }
  std::optional<LiSample> sampleLi(const Vec3f& point, float pick, const Vec2f& u) const override {
    return scaled(light->sampleLi(point, pick, u));
  }
  std::optional<LiSample> sampleLiAt(float time, const Vec3f& point, float pick,
                                     const Vec2f& u) const override {
    return scaled(light->sampleLiAt(time, point, pick, u));
  }

 protected:
  std::unique_ptr<Base> light;
  Rgb scale;

 private:
  std::optional<LiSample> scaled(std::optional<LiSample> li) const {
    if (li) li->radiance *= scale;
    return li;
  }
};

class ScaledAreaLight final : public Scaled<AreaLight> {
 public:
  ScaledAreaLight(std::unique_ptr<AreaLight> light, const Rgb& scale, const Shape& shape)
      : Scaled(std::move(light), scale, shape) {}
  Rgb radiance(const SurfacePoint& point, const Vec3f& direction) const override {
    return scale * light->radiance(point, direction);
  }
  float pdfLi(const Vec3f& from, uint32_t primitive, const SurfacePoint& point) const override {
    return light->pdfLi(from, primitive, point);
  }
};

class ScaledEnvironmentLight final : public Scaled<EnvironmentLight> {
 public:
  using Scaled::Scaled;
  Rgb radiance(const Vec3f& direction) const override { return scale * light->radiance(direction); }
  float pdfLi(const Vec3f& from, const Vec3f& direction) const override {
    return light->pdfLi(from, direction);
  }
};

} // namespace

std::unique_ptr<Light> scaledLight(std::unique_ptr<Light> light, const Rgb& scale) {
  if (auto* environment = dynamic_cast<EnvironmentLight*>(light.get())) {
    light.release();
    return std::make_unique<ScaledEnvironmentLight>(std::unique_ptr<EnvironmentLight>(environment), scale);
  }
  return std::make_unique<Scaled<Light>>(std::move(light), scale);
}

std::unique_ptr<AreaLight> scaledAreaLight(std::unique_ptr<AreaLight> light, const Rgb& scale) {
  const Shape& shape = light->shape();
  return std::make_unique<ScaledAreaLight>(std::move(light), scale, shape);
}

} // namespace recurse
