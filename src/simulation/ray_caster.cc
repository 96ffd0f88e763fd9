#include "planegraph/simulation/ray_caster.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

namespace planegraph {

struct RayCaster::Impl {
  explicit Impl(LabelledMesh m);
  ~Impl();
  void BuildGeometry();

  LabelledMesh mesh;
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
};

RayCaster::Impl::Impl(LabelledMesh m) : mesh(std::move(m)) {
  // One thread builds the same tree each time, and the meshes are small.
  device = rtcNewDevice("threads=1");
  if (device == nullptr) throw std::runtime_error("Embree has no device");
  scene = rtcNewScene(device);
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  BuildGeometry();
  rtcCommitScene(scene);
  if (rtcGetDeviceError(device) != RTC_ERROR_NONE) {
    throw std::runtime_error("Embree cannot build the scene");
  }
}

RayCaster::Impl::~Impl() {
  rtcReleaseScene(scene);
  rtcReleaseDevice(device);
}

void RayCaster::Impl::BuildGeometry() {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                               RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                                               mesh.vertices.size()));
  auto* indices = static_cast<unsigned*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                              3 * sizeof(unsigned), mesh.triangles.size()));
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    for (int k = 0; k < 3; ++k) vertices[3 * i + k] = static_cast<float>(mesh.vertices[i][k]);
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (int k = 0; k < 3; ++k) indices[3 * i + k] = static_cast<unsigned>(mesh.triangles[i][k]);
  }
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
}

RayCaster::RayCaster(const LabelledMesh& mesh) : impl_(std::make_unique<Impl>(mesh)) {}
RayCaster::~RayCaster() = default;
RayCaster::RayCaster(RayCaster&&) noexcept = default;

namespace {

RTCRayHit MakeRay(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                  double max_distance) {
  RTCRayHit ray{};
  ray.ray.org_x = static_cast<float>(origin.x());
  ray.ray.org_y = static_cast<float>(origin.y());
  ray.ray.org_z = static_cast<float>(origin.z());
  ray.ray.dir_x = static_cast<float>(direction.x());
  ray.ray.dir_y = static_cast<float>(direction.y());
  ray.ray.dir_z = static_cast<float>(direction.z());
  ray.ray.tfar = static_cast<float>(max_distance);
  ray.ray.mask = std::numeric_limits<unsigned>::max();
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  return ray;
}

}  // namespace

std::optional<RayCaster::Hit> RayCaster::Cast(const Eigen::Vector3d& origin,
                                              const Eigen::Vector3d& direction,
                                              double max_distance) const {
  RTCRayHit ray = MakeRay(origin, direction, max_distance);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(impl_->scene, &context, &ray);
  if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  const int label = impl_->mesh.labels[ray.hit.primID];
  if (label == kNotPlanar) {
    const Eigen::Vector3d normal =
        Eigen::Vector3d(ray.hit.Ng_x, ray.hit.Ng_y, ray.hit.Ng_z).normalized();
    const double slope = normal.dot(direction);
    return Hit{ray.ray.tfar, std::abs(slope), label, slope > 0.0 ? -normal : normal};
  }
  const Plane& plane = impl_->mesh.planes[label];
  const double slope = plane.normal.dot(direction);
  const double distance = -plane.SignedDistance(origin) / slope;
  return Hit{std::clamp(distance, 0.0, max_distance), std::abs(slope), label,
             slope > 0.0 ? -plane.normal : plane.normal};
}

}  // namespace planegraph
