// SPDX-License-Identifier: MIT
#include "checkpoint.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace crease {
namespace {

static_assert(std::endian::native == std::endian::little, "checkpoints are little-endian");

constexpr std::string_view magic = "crease checkpoint 5\n";

/// FNV-1a, 64 bit: finds a damaged file, not a forged one.
std::uint64_t hash(std::string_view bytes) {
  std::uint64_t value = 14695981039346656037u;
  for (const char byte : bytes) value = (value ^ static_cast<unsigned char>(byte)) * 1099511628211u;
  return value;
}

class Writer {
 public:
  template <class T>
  void put(const T& value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void put_text(std::string_view text) {
    put(static_cast<std::uint64_t>(text.size()));
    bytes_ += text;
  }
  /// Numbers of equal-sized Eigen vectors, one behind the other.
  template <class V>
  void put_vectors(const std::vector<V>& values) {
    for (const V& value : values)
      for (int i = 0; i < value.size(); ++i) put(value[i]);
  }
  std::string& bytes() { return bytes_; }

 private:
  std::string bytes_;
};

class Reader {
 public:
  explicit Reader(std::string_view bytes) : bytes_(bytes) {}
  template <class T>
  T get() {
    T value;
    std::memcpy(&value, take(sizeof value).data(), sizeof value);
    return value;
  }
  std::string_view get_text() { return take(get<std::uint64_t>()); }
  /// A count of things of at least `size` bytes each; one that cannot be true is refused before anything is allocated.
  int get_count(std::size_t size) {
    const auto count = get<std::int32_t>();
    if (count < 0 || static_cast<std::size_t>(count) > bytes_.size() / size)
      throw std::runtime_error("checkpoint is damaged");
    return count;
  }
  template <class V>
  std::vector<V> get_vectors(int count) {
    std::vector<V> values(static_cast<std::size_t>(count));
    for (V& value : values)
      for (int i = 0; i < value.size(); ++i) value[i] = get<double>();
    return values;
  }
  bool at_end() const { return bytes_.empty(); }

 private:
  std::string_view take(std::size_t n) {
    if (n > bytes_.size()) throw std::runtime_error("checkpoint is damaged");
    const std::string_view part = bytes_.substr(0, n);
    bytes_.remove_prefix(n);
    return part;
  }
  std::string_view bytes_;
};

void put_cloth(Writer& out, const Cloth& cloth) {
  const Mesh& mesh = cloth.mesh;
  out.put(static_cast<std::int32_t>(mesh.n_vertices()));
  out.put(static_cast<std::int32_t>(mesh.n_faces()));
  for (int f = 0; f < mesh.n_faces(); ++f) out.put(mesh.face(f));
  for (int h = 0; h < 3 * mesh.n_faces(); ++h) out.put(static_cast<std::int32_t>(mesh.tag(h)));
  out.put_vectors(mesh.X);
  out.put_vectors(mesh.x);
  out.put_vectors(cloth.V);
  out.put_vectors(cloth.v);
  for (const FeatureId& id : cloth.feature) {
    out.put(std::array<std::int32_t, 5>{id.obstacle, static_cast<std::int32_t>(id.kind), id.index, id.side, id.lifted});
    out.put(id.away);
  }
  out.put(static_cast<std::int32_t>(cloth.left.size()));
  for (const LeftStretch& left : cloth.left) {
    const FeatureId& id = left.feature;
    out.put(std::array<std::int32_t, 3>{id.obstacle, static_cast<std::int32_t>(id.kind), id.index});
    out.put(std::array<double, 3>{left.from, left.to, left.age});
  }
  for (const std::uint64_t pins : cloth.pins) out.put(pins);
  out.put(static_cast<std::int32_t>(mesh.has_seams() ? mesh.n_vertices() : 0));
  for (int v = 0; mesh.has_seams() && v < mesh.n_vertices(); ++v) out.put(static_cast<std::int32_t>(mesh.tied(v)));
}

Cloth get_cloth(Reader& in) {
  const int n_vertices = in.get_count(sizeof(double) * 10);
  const int n_faces = in.get_count(sizeof(std::int32_t) * 6);
  std::vector<std::array<int, 3>> faces(static_cast<std::size_t>(n_faces));
  for (auto& face : faces) face = in.get<std::array<int, 3>>();
  std::vector<int> tags(3 * faces.size());
  for (int& tag : tags) tag = in.get<std::int32_t>();
  std::vector<Vec2> X = in.get_vectors<Vec2>(n_vertices);
  std::vector<Vec3> x = in.get_vectors<Vec3>(n_vertices);
  Cloth cloth = make_cloth(Mesh(std::move(X), std::move(x), faces));
  for (int h = 0; h < static_cast<int>(tags.size()); ++h)
    if (tags[h] != 0) cloth.mesh.set_tag(h, tags[h]);
  cloth.V = in.get_vectors<Vec2>(n_vertices);
  cloth.v = in.get_vectors<Vec3>(n_vertices);
  for (FeatureId& id : cloth.feature) {
    const auto [obstacle, kind, index, side, lifted] = in.get<std::array<std::int32_t, 5>>();
    id = {obstacle, static_cast<FeatureKind>(kind), index, side, lifted != 0, in.get<double>()};
  }
  cloth.left.resize(static_cast<std::size_t>(in.get_count(sizeof(double) * 3)));
  for (LeftStretch& left : cloth.left) {
    const auto [obstacle, kind, index] = in.get<std::array<std::int32_t, 3>>();
    left.feature = {.obstacle = obstacle, .kind = static_cast<FeatureKind>(kind), .index = index};
    const auto [from, to, age] = in.get<std::array<double, 3>>();
    left.from = from, left.to = to, left.age = age;
  }
  for (std::uint64_t& pins : cloth.pins) pins = in.get<std::uint64_t>();
  const int n_ties = in.get_count(sizeof(std::int32_t));
  for (int v = 0; v < n_ties; ++v) {
    const auto tied = in.get<std::int32_t>();
    if (v >= n_vertices || tied < 0 || tied >= n_vertices) throw std::runtime_error("checkpoint is damaged");
    cloth.mesh.tie(v, tied);
  }
  return cloth;
}

/// A reader of what stands between the first line and the hash, both found right.
Reader open_checkpoint(std::string_view bytes) {
  if (!bytes.starts_with(magic)) throw std::runtime_error("not a checkpoint of this version");
  const std::size_t body = bytes.size() - std::min(bytes.size(), sizeof(std::uint64_t));
  if (body < magic.size() || Reader(bytes.substr(body)).get<std::uint64_t>() != hash(bytes.substr(0, body)))
    throw std::runtime_error("checkpoint is damaged");
  return Reader(bytes.substr(0, body).substr(magic.size()));
}

}  // namespace

std::string encode_checkpoint(const std::string& scene, int step, std::span<const Cloth> cloths) {
  Writer out;
  out.bytes() = magic;
  out.put_text(scene);
  out.put(static_cast<std::int32_t>(step));
  out.put(static_cast<std::int32_t>(cloths.size()));
  for (const Cloth& cloth : cloths) put_cloth(out, cloth);
  out.put(hash(out.bytes()));
  return std::move(out.bytes());
}

bool belongs_to(std::string_view bytes, const std::string& scene) {
  return open_checkpoint(bytes).get_text() == scene;
}

Checkpoint decode_checkpoint(std::string_view bytes) {
  Reader in = open_checkpoint(bytes);
  in.get_text();
  Checkpoint checkpoint;
  checkpoint.step = in.get<std::int32_t>();
  const int n_cloths = in.get_count(1);
  for (int c = 0; c < n_cloths; ++c) checkpoint.cloths.push_back(get_cloth(in));
  if (!in.at_end()) throw std::runtime_error("checkpoint is damaged: something follows its end");
  return checkpoint;
}

}  // namespace crease
