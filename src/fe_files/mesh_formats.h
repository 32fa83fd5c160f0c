#pragma once
#include <memory>
#include <string>
#include <string_view>

#include "fe_files/text_file.h"
#include "mimbre/fe_import.h"

/// The text formats of meshes. A new one is a file like unv.cpp, which parses it and describes it, and its
/// name in this list.
namespace mimbre::fe {

struct MeshFormat {
  std::string_view ending;   ///< of its files, in lower case: ".msh"
  std::string_view program;  ///< that writes them
  std::string_view help;     ///< lines of what is read of it
  /// In the file's units; assembles and reduces nothing. `folder`: that of the file, for what it includes.
  ImportedMesh (*parse)(std::unique_ptr<TextFile> file, const std::string& folder);
};

extern const MeshFormat gmsh_format, inp_format, unv_format;
inline constexpr const MeshFormat* mesh_formats[] = {&gmsh_format, &inp_format, &unv_format};

/// By the file's ending; null: it is none of them.
const MeshFormat* find_mesh_format(const std::string& path);

}  // namespace mimbre::fe
