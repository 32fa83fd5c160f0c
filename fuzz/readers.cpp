#include "readers.h"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "base/checksums.h"
#include "fe_files/bodies/reduced_files.h"
#include "fe_files/bodies/stress_matrix.h"
#include "fe_files/bodies/user_modes_file.h"
#include "fe_files/gmsh.h"
#include "fe_files/inp/calculix.h"
#include "fe_files/inp/inp_model.h"
#include "fe_files/matrices/matrix_files.h"
#include "fe_files/mesh_formats.h"
#include "fe_files/nastran/nastran.h"
#include "fe_files/node_table.h"
#include "fmu/package.h"
#include "mimbre/input_table.h"
#include "mimbre/model.h"
#include "mimbre/model_file.h"
#include "mimbre/results.h"
#include "mimbre/surface_mesh.h"
#include "mimbre/urdf.h"
#include "model_file/text/parse.h"
#include "roads/crg_file.h"
#include "tyre_files/parse_tyre.h"

namespace mimbre::fuzz {
namespace {

namespace fs = std::filesystem;
using namespace fe;

std::string file_bytes(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error("cannot read " + path.string());
  return {std::istreambuf_iterator<char>(file), {}};
}

/// A folder of this process for formats that are read from files; it goes with the process that made it.
class Scratch {
 public:
  Scratch() : owner_(getpid()) {
    std::string name = (fs::temp_directory_path() / "mimbre-fuzz-XXXXXX").string();
    if (!mkdtemp(name.data())) throw std::runtime_error("no folder for temporary files");
    folder_ = name;
  }
  ~Scratch() {
    std::error_code ignored;
    if (getpid() == owner_) fs::remove_all(folder_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  std::string path(const std::string& name) const { return (folder_ / name).string(); }

 private:
  pid_t owner_;
  fs::path folder_;
};
const Scratch& scratch() {
  static const Scratch folder;
  return folder;
}

std::string written(const std::string& bytes, const std::string& name) {
  const std::string path = scratch().path(name);
  std::ofstream(path, std::ios::binary) << bytes;
  return path;
}

/// A mesh of so many nodes in a plane, for readers that need one.
SolidMesh nodes(int count) {
  SolidMesh mesh;
  mesh.nodes = Eigen::Matrix3Xd::Zero(3, count);
  for (int k = 0; k < count; ++k) mesh.labels.push_back(k + 1);
  return mesh;
}
const std::vector<Dof> four_rows = {{0, 0}, {0, 1}, {1, 0}, {1, 1}};

/// A reader of text as one of bytes; what comes before it may refuse the same bytes on its own.
template <class... Reads>
void read_text(const std::string& bytes, Reads&&... reads) {
  std::exception_ptr refusal;
  const auto one = [&](auto&& read) {
    TextFile file(bytes, "fuzz");
    try {
      read(file);
    } catch (const InputError&) {
      refusal = std::current_exception();
    }
  };
  (one(reads), ...);
  if (refusal) std::rethrow_exception(refusal);
}

/// What is made of a mesh must stand any numbers in it; other refusals are good there, too.
void reduce_mesh(const ImportedMesh& read) {
  if (read.mesh.nodes.cols() > 60) return;
  try {
    SolidMesh mesh = read.mesh;
    if (mesh.materials.empty()) {
      mesh.materials = {{"steel", {2.1e11, 0.3, 7800}}};
      for (ElementGroup& group : mesh.groups) group.material = 0;
    }
    const FeMatrices matrices = assemble(mesh, 1);
    ModelReduction options;
    Interface interface;
    interface.name = "end";
    const int first = matrices.dofs.empty() ? 0 : matrices.dofs.front().node;
    const double x = mesh.nodes.cols() > 0 ? mesh.nodes(0, first) : 0;
    for (const Dof& dof : matrices.dofs)
      if (dof.direction == 0 && mesh.nodes(0, dof.node) == x) interface.nodes.push_back(dof.node);
    interface.point = centre_of(mesh, interface.nodes);
    options.interfaces = {interface};
    options.dynamic_modes = 3;
    options.free_modes = 2;
    for (const auto basis : {ModelReduction::Basis::craig_bampton, ModelReduction::Basis::free_interface}) {
      options.basis = basis;
      reduce(mesh, matrices, options);
    }
  } catch (const InputError&) {
    throw;
  } catch (const std::invalid_argument&) {
  } catch (const std::runtime_error&) {
  }
}

void read_model_text(const std::string& bytes) {
  model_file::Limits limits;
  limits.bytes = 1u << 16;
  limits.nodes = 5000;
  limits.elements = 20;
  limits.all_elements = 100;
  limits.dynamic_modes = 4;
  Model::compile(model_file::parse(bytes, "fuzz.yaml", "", {}, nullptr, limits));
}

std::vector<std::string> files(const std::string& sources, std::initializer_list<const char*> names) {
  std::vector<std::string> result;
  for (const char* name : names) result.push_back(file_bytes(fs::path(sources) / name));
  return result;
}

/// A small body of beams.
ReducedBody sample_body() {
  return *parse_model(R"(mimbre: 1
materials:
  steel: {young: 2.1e11, poisson: 0.3, density: 7850}
sections:
  round: {type: round, diameter: 0.01}
bodies:
  arm:
    frame: {at: [0, 0, 0]}
    flexible:
      material: steel
      section: round
      nodes: {a: [0, 0, 0], b: [1, 0, 0]}
      bars: {bar: {from: a, to: b, elements: 3}}
      clamped: [a]
      static_modes: [{node: b, along: [0, 0, 1], name: tip}]
      dynamic_modes: 1
joints:
  hinge: {type: revolute, between: [ground, arm], at: [0, 0, 0], axis: [0, 1, 0]}
simulation: {step: 0.01, end: 1}
)",
                      "sample.yaml", "")
              .bodies[0]
              .flexible;
}

std::string body_as(BodyFormat format, const char* name) {
  const std::string path = scratch().path(name);
  write_body(sample_body(), path, format);
  return file_bytes(path);
}

/// With checksums, which hide from the reader what is damaged, and without.
std::vector<std::string> sample_bodies(const std::string&) {
  std::vector<std::string> samples{body_as(BodyFormat::h5, "sample.h5")};
  hdf5::remove_checksums(scratch().path("sample.h5"));
  samples.push_back(file_bytes(scratch().path("sample.h5")));
  return samples;
}

/// One that came to its end, and one that was cut short; the latter without checksums.
std::vector<std::string> sample_results(const std::string&) {
  ResultsHeader header;
  header.title = "A pendulum";
  header.model_text = "mimbre: 1\n";
  header.options_json = "{}";
  header.step = 0.01;
  header.channels = {{"angle", "rad", "angle of the hinge"}, {"energy", "J", ""}};
  BodyDrawing body;
  body.name = "arm";
  body.modes = 2;
  body.points = Eigen::Matrix3Xd::Random(3, 4);
  body.point_shapes = Eigen::MatrixXd::Random(12, 2);
  body.lines = {{0, 1}, {1, 2}};
  body.triangles = {{0, 1, 2}};
  body.labels = {1, 2, 3, 4};
  body.stress = Eigen::MatrixXd::Random(24, 2);
  body.shapes.resize(1);
  header.bodies = {body};
  header.roads = {{"track", Eigen::Matrix2Xd::Random(2, 3)}};
  std::vector<std::string> samples;
  for (const bool whole : {true, false}) {
    const std::string path = scratch().path(whole ? "whole.h5" : "cut.h5");
    {
      ResultsWriter writer(path, header);
      for (int i = 0; i < 70; ++i)
        writer.add(
            {0.01 * i, Eigen::Vector2d(i, 1), Eigen::Matrix<double, 7, 1>::Ones(), Eigen::Vector2d::Zero()});
      if (whole) writer.finish("{}");
    }
    if (!whole) hdf5::remove_checksums(path);
    samples.push_back(file_bytes(path));
  }
  return samples;
}

const char* const abaqus_labelled = "1,1,1,1,2.0e5\n1,2,1,1,-1.0\n1,2,1,2,3.5\n2,1,1,1,0.5\n2,1,2,1,7.0\n";
const char* const abaqus_coordinates = "1 1 2.0e5\n2 1 -1.0\n2 2 3.5\n3 3 0.5\n4 4 7.0\n";
const char* const nastran_punch =
    "GRID           1              0.      0.      0.\nGRID,2,,1.0,0.0,0.0\n"
    "CORD2R         5              0.      0.      0.      0.      0.      1.\n+             1.      0.      "
    "0.\n"
    "DMIG    KAAX           0       6       1       0                       4\n"
    "DMIG*   KAAX                           1               1\n"
    "*                      1               1 2.000000000D+05\n"
    "DMIG*   KAAX                           2               1\n"
    "*                      1               1-1.000000000D+00\n"
    "*                      2               1 3.500000000D+00\n";
const char* const nastran_solids =
    "CORD2C,5,,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\nCORD1R,6,1,2,4\nGRDSET,,,,,,\n"
    "GRID           1              0.      0.      "
    "0.\nGRID,2,5,1.,0.,0.\nGRID,3,,1.,1.,0.\nGRID,4,5,1.,90.,0.\n"
    "GRID*                  5                             0.0             0.0*\n*                    1.0\n"
    "GRID,6,,1.,0.,1.\nGRID,7,,1.,1.,1.\nGRID,8,,0.,1.,1.\nGRID,9,,.5,.5,2.\n"
    "CHEXA,1,1,1,2,3,4,5,6\n+,7,8\nCPYRAM,2,2,5,6,7,8,9\nPSOLID,1,1\nPSOLID,2,2,6\n"
    "MAT1,1,2.1+11,,.3,7800.\nMAT9,2,3.+11,1.+11,1.+11,,,,3.+11\n,1.+11,,,,3.+11,,,\n,1.+11,,,1.+11,,1.+11,"
    "7800.\n"
    "SPC1,1,123,1,THRU,4\nENDDATA\n";
const char* const nastran_frame =
    "CORD2S,5,,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\nGRID,1,,0.,0.,0.,5\nGRID,2,,1.,0.,0.,5\nGRID,3,,1.,1.,0.\nGRID,"
    "4,,0.,1.,0.\n"
    "GRID,5,,0.,0.,1.\nGRID,6,,0.,0.,2.\nMAT1,1,2.1+11,,.3,7800.\nMAT8,2,1.4+11,1.+10,.3,5.+9,,,1600.\n"
    "PSHELL,1,1,.01,1,2.,1,1.,3.\nPCOMP,2,,,,,,,SYM\n,2,.001,0.,,2,.001,90.\n"
    "CQUAD4,1,1,1,2,3,4\nCTRIA3,2,2,1,2,3,5\nCBAR,3,3,1,5,1.,1.,0.,,\n,4,,.1,0.,0.\nPBARL,3,1,,I,,,,,\n,.1,."
    "05,.05,.005,.005,.005\n"
    "CBEAM,4,4,5,6,1.,1.,0.\nPBEAML,4,1,,L,,,,,\n,.1,.1,.01,.01\nCROD,5,5,1,3\nPROD,5,1,1.-4,1.-8\n"
    "RBE2,10,6,1246,3,4\nRBE3,11,,5,123,1.,123,1,2,,\n,3\nCONM2,12,6,,2.,.1\nCELAS2,13,5.,1,1,2,1\nCBUSH,14,"
    "7,1,4,,,,0\n"
    "PBUSH,7,K,1.,2.,3.\nMPC,1,1,3,1.,2,3,-1.\nENDDATA\n";
const char* const user_modes = "node,x1,y1,z1,x2,y2,z2\n1,0,0,0,0,0,0\n2,0,0.1,0,0,0,0.2\n3,0,1,0,0,0,1\n";
const char* const node_table = "label,x,y,z\n1,0,0,0\n2,1,0,0\n3;1.5;0;1e-3\n";

}  // namespace

const std::vector<Reader>& readers() {
  static const std::vector<Reader> all{
      {"model_file", read_model_text,
       [](const std::string& s) {
         return files(s, {"examples/tutorial/four-bar.yaml", "examples/tutorial/flexible.yaml",
                          "examples/slider-crank/slider-crank.yaml", "examples/bricard/mechanism.yaml",
                          "tests/data/hard/axle.yaml", "examples/iltis/corner.yaml",
                          "examples/ball-cascade/model.yaml", "examples/rotor/model.yaml",
                          "examples/double-wishbone/model.yaml", "examples/contact/stairs.yaml"});
       }},
      {"results", [](const std::string& bytes) { read_results(written(bytes, "results.h5")); },
       sample_results},
      {"body", [](const std::string& bytes) { load_reduced_body(written(bytes, "body.h5")); }, sample_bodies},
      {"gmsh",
       [](const std::string& bytes) {
         read_text(bytes, [](TextFile& file) { reduce_mesh(parse_gmsh(file)); });
       },
       [](const std::string& s) {
         return files(
             s, {"tests/data/gmsh/block-22.msh", "tests/data/gmsh/block-41.msh", "tests/data/gmsh/plate.msh",
                 "tests/data/gmsh/hex20.msh", "tests/data/gmsh/wedge15.msh"});
       }},
      {"inp",
       [](const std::string& bytes) {
         reduce_mesh(parse_inp(std::make_unique<TextFile>(bytes, "fuzz"), "", false));
       },
       [](const std::string& s) {
         return files(s, {"tests/data/calculix/beam.inp", "tests/data/calculix/elements/C3D4.inp",
                          "tests/data/calculix/elements/C3D10.inp", "tests/data/calculix/elements/C3D8.inp",
                          "tests/data/gmsh/block.inp"});
       }},
      {"unv",
       [](const std::string& bytes) {
         reduce_mesh(unv_format.parse(std::make_unique<TextFile>(bytes, "fuzz"), ""));
       },
       [](const std::string& s) {
         return files(s, {"tests/data/unv/tet10.unv", "tests/data/unv/hex20.unv",
                          "tests/data/unv/wedge15.unv", "tests/data/unv/quad8.unv"});
       }},
      {"calculix",
       [](const std::string& bytes) {
         read_text(
             bytes, [](TextFile& file) { parse_calculix_dofs(file, nodes(4)); },
             [](TextFile& file) { parse_calculix_matrix(file, four_rows); });
       },
       [](const std::string& s) {
         std::vector<std::string> samples = files(s, {"tests/data/calculix/beam.dof"});
         samples.push_back("1 1 2.0e5\n1 2 -1.0\n2 2 3.5\n3 3 0.5\n4 4 7.0\n");
         return samples;
       }},
      {"abaqus",
       [](const std::string& bytes) {
         read_text(
             bytes,
             [](TextFile& file) {
               abaqus_is_labelled(file) ? parse_abaqus_labelled(file, nodes(4))
                                        : parse_abaqus_coordinates(file, four_rows);
             },
             [](TextFile& file) { count_abaqus_rows(file); });
       },
       [](const std::string&) {
         return std::vector<std::string>{abaqus_labelled, abaqus_coordinates};
       }},
      {"nastran",
       [](const std::string& bytes) {
         SolidMesh mesh = nodes(4);
         read_text(bytes, [&](TextFile& file) {
           NastranLines lines(file);
           parse_dmig(lines, {"KAAX"}, mesh);
         });
         read_text(bytes, [](TextFile& file) { reduce_mesh(parse_nastran(file)); });
       },
       [](const std::string&) {
         return std::vector<std::string>{nastran_punch, nastran_solids, nastran_frame};
       }},
      {"matrix_market",
       [](const std::string& bytes) {
         read_text(bytes, [](TextFile& file) {
           MatrixMarketHead head = parse_matrix_market_head(file);
           head.rows = std::min<std::int64_t>(head.rows, 4);
           Triangles triangles;
           parse_matrix_market_entries(file, head, four_rows, triangles);
         });
       },
       [](const std::string& s) {
         std::vector<std::string> samples = files(s, {"tests/data/scipy/mass.mtx"});
         samples.push_back(
             "%%MatrixMarket matrix coordinate real symmetric\n4 4 3\n1 1 2.0\n2 1 -1\n4 4 1e3\n");
         return samples;
       }},
      {"npz", [](const std::string& bytes) { parse_npz(bytes, "fuzz"); },
       [](const std::string& s) {
         return files(s, {"tests/data/scipy/mass-coo.npz", "tests/data/scipy/mass-csc.npz",
                          "tests/data/scipy/stiffness-csr.npz"});
       }},
      {"fmu", [](const std::string& bytes) { fmu::Package::open(written(bytes, "block.fmu")); },
       [](const std::string& s) {
         return files(s, {"tests/data/fmu/unit-2.fmu", "tests/data/fmu/unit-3.fmu"});
       }},
      {"node_table",
       [](const std::string& bytes) {
         read_text(
             bytes, [](TextFile& file) { parse_node_table(file); },
             [](TextFile& file) { parse_dof_table(file, nodes(4)); });
       },
       [](const std::string& s) {
         std::vector<std::string> samples =
             files(s, {"tests/data/scipy/nodes.csv", "tests/data/scipy/dofs.csv"});
         samples.push_back(node_table);
         return samples;
       }},
      {"stl",
       [](const std::string& bytes) { why_not_closed(read_surface_mesh(written(bytes, "surface.stl"))); },
       [](const std::string& s) {
         return files(s, {"tests/data/surfaces/block.stl", "tests/data/surfaces/block-text.stl"});
       }},
      {"obj",
       [](const std::string& bytes) { why_not_closed(read_surface_mesh(written(bytes, "surface.obj"))); },
       [](const std::string& s) { return files(s, {"tests/data/surfaces/block.obj"}); }},
      {"glb",
       [](const std::string& bytes) { why_not_closed(read_surface_mesh(written(bytes, "surface.glb"))); },
       [](const std::string& s) { return files(s, {"tests/data/surfaces/block.glb"}); }},
      {"urdf", [](const std::string& bytes) { convert_urdf(written(bytes, "robot.urdf")); },
       [](const std::string& s) {
         return files(s, {"tests/data/urdf/ur5.urdf", "tests/data/urdf/panda.urdf"});
       }},
      {"input_table",
       [](const std::string& bytes) {
         spec::Input torque, speed;
         torque.name = "torque";
         torque.unit = "N m";
         speed.name = "speed";
         const std::string path = written(bytes, "inputs.csv");
         const std::vector<spec::Input> inputs{torque, speed};
         try {
           read_input_table(path, inputs, "torque");
         } catch (const InputError&) {
         }
         read_input_table(path, inputs);
       },
       [](const std::string&) {
         return std::vector<std::string>{"t [s];torque [N m];speed\n0;1,5;\"2\"\n0,5;2;\n# x\n1;3;4\n",
                                         "speed,time\nm/s,s\n0,1\n2,1.5\n", "0\t1\n1\t2.5e3\n"};
       }},
      {"tyre",
       [](const std::string& bytes) {
         read_text(bytes, [](TextFile& file) { tyre_files::parse_tyre(file); });
       },
       [](const std::string& s) {
         return files(s, {"tests/data/tyres/car_205_60R15_61.tir", "tests/data/tyres/car_52.tir"});
       }},
      {"crg", [](const std::string& bytes) { roads::parse_road_grid(bytes, "fuzz"); },
       [](const std::string& s) {
         return files(s, {"tests/data/roads/bend.crg", "tests/data/roads/bend_double.crg",
                          "tests/data/roads/bend_binary.crg", "tests/data/roads/bend_binary_double.crg"});
       }},
      {"mbdyn_fem",
       [](const std::string& bytes) { read_text(bytes, [](TextFile& file) { parse_mbdyn_fem(file); }); },
       [](const std::string&) { return std::vector<std::string>{body_as(BodyFormat::fem, "sample.fem")}; }},
      {"sid", [](const std::string& bytes) { read_text(bytes, [](TextFile& file) { parse_sid(file); }); },
       [](const std::string&) { return std::vector<std::string>{body_as(BodyFormat::sid, "sample.sid")}; }},
      {"stress_matrix",
       [](const std::string& bytes) {
         FeMatrices matrices;
         matrices.dofs = {{0, 0}, {1, 2}, {1, 5}};
         try {
           read_text(bytes, [](TextFile& file) { parse_stress_nodes(file, nodes(2)); });
         } catch (const InputError&) {
         }
         parse_stress_matrix(bytes, "fuzz", {}, nodes(2), matrices, {}, {});
       },
       [](const std::string& s) {
         std::vector<std::string> samples = files(s, {"tests/data/scipy/stiffness-csr.npz"});
         samples.push_back("node\n1\n2\n");
         return samples;
       }},
      {"user_modes",
       [](const std::string& bytes) {
         try {
           read_text(bytes, [](TextFile& file) { parse_user_modes(file, nodes(4)); });
         } catch (const InputError&) {
         }
         parse_user_modes_npz(bytes, "fuzz", nodes(4));
       },
       [](const std::string& s) {
         std::vector<std::string> samples = files(s, {"tests/data/scipy/mass-coo.npz"});
         samples.push_back(user_modes);
         return samples;
       }},
  };
  return all;
}

}  // namespace mimbre::fuzz
