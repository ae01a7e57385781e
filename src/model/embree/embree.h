/** @file
 * Embree 3 or 4: wrappers of the calls that differ between them.
 */
#pragma once

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace recurse::embree {

inline void intersect(RTCScene scene, RTCRayHit& rayHit) {
#if RTC_VERSION_MAJOR >= 4
  rtcIntersect1(scene, &rayHit);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene, &context, &rayHit);
#endif
}

inline void occluded(RTCScene scene, RTCRay& ray) {
#if RTC_VERSION_MAJOR >= 4
  rtcOccluded1(scene, &ray);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(scene, &context, &ray);
#endif
}

constexpr unsigned PACKET = 8;

/** Active rays of a packet: the first `count`, at most all. */
struct Lanes {
  explicit Lanes(size_t count) {
    for (size_t i = 0; i < PACKET; ++i) valid[i] = i < count ? -1 : 0;
  }
  alignas(32) int valid[PACKET];
};

/** `coherent`: the rays have nearly the same origin and direction. */
inline void intersect(RTCScene scene, const Lanes& lanes, RTCRayHit8& rayHits, bool coherent) {
#if RTC_VERSION_MAJOR >= 4
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  if (coherent) arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  rtcIntersect8(lanes.valid, scene, &rayHits, &arguments);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  if (coherent) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersect8(lanes.valid, scene, &context, &rayHits);
#endif
}

inline void occluded(RTCScene scene, const Lanes& lanes, RTCRay8& rays) {
#if RTC_VERSION_MAJOR >= 4
  rtcOccluded8(lanes.valid, scene, &rays);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded8(lanes.valid, scene, &context, &rays);
#endif
}

} // namespace recurse::embree
