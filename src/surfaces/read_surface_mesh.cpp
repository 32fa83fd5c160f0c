#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cctype>
#include <filesystem>
#include <unordered_map>

#include "base/hash64.h"
#include "base/rehearsal.h"
#include "mimbre/surface_mesh.h"
#include "surfaces/check_ply.h"

/// Files of surfaces, by Assimp.
namespace mimbre {
namespace {

namespace fs = std::filesystem;

constexpr int most_nodes = 100000;  ///< of a scene's tree, which a damaged file may close to a ring
constexpr std::size_t most_corners = 3u << 24;  ///< of all triangles

[[noreturn]] void refuse(const std::string& path, const std::string& why) {
  throw InputError(Mark{path, 0, 0}, why);
}

std::string ending_of(const std::string& path) {
  std::string ending = fs::path(path).extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return ending.empty() ? ending : ending.substr(1);
}

std::string endings_in_words() {
  std::string words;
  for (const std::string& ending : surface_mesh_endings()) words += (words.empty() ? "." : ", .") + ending;
  return words;
}

/// Vertices in the same place become one.
class Collector {
 public:
  explicit Collector(const std::string& path) : path_(path) {}

  void add(const aiMesh& part, const aiMatrix4x4& place) {
    const bool mirrored = place.Determinant() < 0;
    std::vector<int> numbers;
    numbers.reserve(part.mNumVertices);
    for (unsigned k = 0; k < part.mNumVertices; ++k) numbers.push_back(vertex(place * part.mVertices[k]));
    for (unsigned k = 0; k < part.mNumFaces; ++k) {
      const aiFace& face = part.mFaces[k];
      if (face.mNumIndices != 3) continue;  // points and lines
      std::array<int, 3> corners{};
      for (unsigned c = 0; c < 3; ++c) {
        if (face.mIndices[c] >= part.mNumVertices)
          refuse(path_, "is damaged: a triangle names a vertex that is not there");
        corners[c] = numbers[face.mIndices[c]];
      }
      if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) continue;
      if (mirrored) std::swap(corners[1], corners[2]);
      triangles_.push_back(corners);
      if (3 * triangles_.size() > most_corners)
        refuse(path_, fmt::format("has more than {} triangles", most_corners / 3));
    }
  }

  SurfaceMesh finish() {
    SurfaceMesh mesh;
    // Without those of points, lines and triangles that were left out.
    std::vector<int> number(points_.size(), -1);
    int count = 0;
    for (const auto& triangle : triangles_)
      for (const int corner : triangle) number[static_cast<std::size_t>(corner)] = 0;
    for (int& k : number)
      if (k == 0) k = count++;
    mesh.vertices.resize(3, count);
    for (std::size_t k = 0; k < points_.size(); ++k)
      if (number[k] >= 0) mesh.vertices.col(number[k]) = points_[k];
    for (auto& triangle : triangles_)
      for (int& corner : triangle) corner = number[static_cast<std::size_t>(corner)];
    mesh.triangles = std::move(triangles_);
    return mesh;
  }

 private:
  using Place = std::array<double, 3>;
  struct Hash {
    std::size_t operator()(const Place& place) const {
      Hash64 hash;
      for (const double number : place) hash.add(number);
      return static_cast<std::size_t>(hash.value());
    }
  };

  int vertex(const aiVector3D& p) {
    const Place place{p.x, p.y, p.z};
    const Eigen::Map<const Eigen::Vector3d> point(place.data());
    if (!point.allFinite()) refuse(path_, "has a vertex whose coordinates are not finite");
    const auto [at, fresh] = numbers_.try_emplace(place, static_cast<int>(points_.size()));
    if (fresh) points_.push_back(point);
    return at->second;
  }

  const std::string& path_;
  std::vector<Eigen::Vector3d> points_;
  std::vector<std::array<int, 3>> triangles_;
  std::unordered_map<Place, int, Hash> numbers_;
};

/// Cameras and lights are no part of a surface: what is wrong with them shall not matter.
template <class T>
void remove_all(T**& things, unsigned& count) {
  for (unsigned k = 0; k < count; ++k) delete things[k];
  delete[] things;
  things = nullptr;
  count = 0;
}

const aiScene* import(Assimp::Importer& importer, const std::string& path) {
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  if (!importer.ReadFile(path, 0)) return nullptr;
  // The importer owns the scene and hands it out const; this is where it may be changed.
  auto* scene = const_cast<aiScene*>(importer.GetScene());
  remove_all(scene->mCameras, scene->mNumCameras);
  remove_all(scene->mLights, scene->mNumLights);
  return importer.ApplyPostProcessing(aiProcess_ValidateDataStructure | aiProcess_Triangulate);
}

SurfaceMesh read(const std::string& path) {
  Assimp::Importer importer;
  const aiScene* scene = import(importer, path);
  if (!scene || !scene->mRootNode) {
    std::string why = importer.GetErrorString();
    std::replace(why.begin(), why.end(), '\n', ' ');
    refuse(path, fmt::format("cannot be read as a surface: {}", why.empty() ? "it is damaged" : why));
  }
  Collector collector(path);
  struct Visit {
    const aiNode* node;
    aiMatrix4x4 outer;
  };
  std::vector<Visit> open{{scene->mRootNode, aiMatrix4x4()}};
  for (int visited = 0; !open.empty(); ++visited) {
    if (visited >= most_nodes) refuse(path, fmt::format("has more than {} parts", most_nodes));
    const Visit visit = open.back();
    open.pop_back();
    const aiMatrix4x4 place = visit.outer * visit.node->mTransformation;
    for (unsigned k = 0; k < visit.node->mNumMeshes; ++k)
      collector.add(*scene->mMeshes[visit.node->mMeshes[k]], place);
    for (unsigned k = visit.node->mNumChildren; k > 0; --k)
      open.push_back({visit.node->mChildren[k - 1], place});
  }
  SurfaceMesh mesh = collector.finish();
  if (mesh.triangles.empty()) refuse(path, "has no triangle with an area");
  return mesh;
}

}  // namespace

const std::vector<std::string>& surface_mesh_endings() {
  static const std::vector<std::string> endings{"stl", "obj", "gltf", "glb", "ply", "dae"};
  return endings;
}

SurfaceMesh read_surface_mesh(const std::string& path) {
  const auto& endings = surface_mesh_endings();
  const std::string ending = ending_of(path);
  if (std::find(endings.begin(), endings.end(), ending) == endings.end())
    refuse(path, fmt::format("is no surface of triangles by its name; its end must be one of {}",
                             endings_in_words()));
  std::error_code status;
  if (!fs::is_regular_file(path, status)) refuse(path, "there is no such file");
  if (ending == "ply")
    if (const std::string why = why_not_ply(path); !why.empty()) refuse(path, why);
  // What damaged files do to the importer is done to another process.
  rehearse("surface", path);
  return read(path);
}

}  // namespace mimbre
