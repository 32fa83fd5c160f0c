#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "model_file/sections/bar_paths.h"
#include "model_file/text/builder.h"
#include "spec/output_kind.h"

/// Substructuring (Wu, Haug 1988; Lugrís 2008, 4.2): a beam that bends far is cut into bodies, each of which
/// bends little in its own frame, joined by brackets. With a frame for each element, and the second order of
/// its bending, this is a corotational beam. Frames of bars are cut where they branch, too.
namespace mimbre::model_file {
namespace {

/// One flexible body of the whole, and where the whole body's nodes are in it.
struct Piece {
  FlexibleDescription description;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< of its frame, in the axes of the whole
  std::vector<int> nodes;                            ///< of the whole, in order; it is clamped at the first
  bool free_end = false;                             ///< nothing is attached to its last node
  bool closes = false;  ///< its last node belongs to another piece, to which a bracket joins it
  int end_frame = -1;   ///< its frame at the last node, which carries the next pieces; -1: at a free end
  int before = -1;      ///< the piece that carries it; -1: the clamped node does
  int first_mode = 0;   ///< its first amplitude among those of the whole

  /// Of its own nodes; -1 when the node is not its own.
  int local(int node) const {
    const auto last = nodes.end() - int(closes);
    const auto found = std::find(nodes.begin(), last, node);
    return found == last ? -1 : static_cast<int>(found - nodes.begin());
  }
};

/// Directions in which no node moves: of a body that is bound to a plane.
std::array<bool, 6> fixed_directions(const FlexibleDescription& whole) {
  std::array<bool, 6> fixed{};
  for (const int dof : whole.options.fixed_dofs) fixed[static_cast<std::size_t>(dof % 6)] = true;
  return fixed;
}

/// Elements [first, last) of a path as a body that is clamped where they begin.
Piece make_piece(const FlexibleDescription& whole, const BarPath& path, int index, int first, int last) {
  Piece piece;
  const bool at_end = last == static_cast<int>(path.elements.size());
  piece.free_end = at_end && path.free_end;
  piece.closes = at_end && path.closes;
  const bool moves_at_end = !piece.free_end || whole.kind == BeamKind::corotational;
  FlexibleDescription& d = piece.description;
  d.mark = whole.mark;
  d.what = fmt::format("{}: substructure {}", whole.what, index + 1);
  d.line_radius = whole.line_radius;
  piece.nodes.assign(path.nodes.begin() + first, path.nodes.begin() + last + 1);
  if (index > 0) piece.origin = whole.mesh.nodes.col(piece.nodes.front());

  d.mesh.nodes.resize(3, static_cast<Eigen::Index>(piece.nodes.size()));
  for (std::size_t k = 0; k < piece.nodes.size(); ++k)
    d.mesh.nodes.col(static_cast<Eigen::Index>(k)) = whole.mesh.nodes.col(piece.nodes[k]) - piece.origin;
  for (int e = first; e < last; ++e) {
    fe::BeamElement element =
        whole.mesh.elements[static_cast<std::size_t>(path.elements[static_cast<std::size_t>(e)])];
    const int k = e - first;
    const bool forward = element.nodes[0] == piece.nodes[static_cast<std::size_t>(k)];
    element.nodes = forward ? std::array{k, k + 1} : std::array{k + 1, k};
    d.mesh.elements.push_back(element);
  }

  d.options = whole.options;
  d.options.clamped_nodes = {0};
  d.options.boundary.clear();
  d.options.fixed_dofs.clear();
  d.options.dynamic_modes = piece.free_end ? whole.options.dynamic_modes : whole.substructures.dynamic_modes;
  const std::array<bool, 6> fixed = fixed_directions(whole);
  const int end = static_cast<int>(piece.nodes.size()) - 1;
  for (int k = 1; k <= end; ++k)
    for (int dof = 0; dof < 6; ++dof) {
      if (fixed[static_cast<std::size_t>(dof)])
        d.options.fixed_dofs.push_back(6 * k + dof);
      else if (k == end && moves_at_end)
        d.options.boundary.push_back({end, dof > 2, Eigen::Vector3d::Unit(dof % 3),
                                      fmt::format("end.{}{}", dof > 2 ? "r" : "", "xyz"[dof % 3])});
    }
  for (fe::BoundaryDof dof : whole.options.boundary) {
    dof.node = piece.local(dof.node);
    // The bracket's modes hold whatever the user wants at its node.
    if (dof.node > 0 && (!moves_at_end || dof.node != end)) d.options.boundary.push_back(dof);
  }
  for (const fe::NodeFrame& frame : whole.frames)
    if (const int node = piece.local(frame.node); node > 0 || (node == 0 && index == 0)) {
      d.frames.push_back(frame);
      d.frames.back().node = node;
    }
  if (!piece.free_end) {
    piece.end_frame = static_cast<int>(d.frames.size());
    d.frames.push_back({"end", end, Eigen::Matrix3d::Identity()});
  }
  return piece;
}

std::vector<Piece> make_pieces(const FlexibleDescription& whole, const std::vector<BarPath>& paths) {
  std::vector<Piece> pieces;
  std::vector<int> last_of_path;
  const std::vector<int> shares = share_pieces(paths, whole.substructures.count);
  for (std::size_t p = 0; p < paths.size(); ++p) {
    const BarPath& path = paths[p];
    const int count = shares[p], elements = static_cast<int>(path.elements.size());
    int before = path.before < 0 ? -1 : last_of_path[static_cast<std::size_t>(path.before)];
    for (int k = 0; k < count; ++k) {
      const int index = static_cast<int>(pieces.size());
      Piece piece = make_piece(whole, path, index, k * elements / count, (k + 1) * elements / count);
      piece.before = before;
      if (index > 0) piece.first_mode = pieces.back().first_mode + mode_count(pieces.back().description);
      pieces.push_back(std::move(piece));
      before = index;
    }
    last_of_path.push_back(before);
  }
  return pieces;
}

std::vector<BarPath> paths_of(const FlexibleDescription& whole) {
  if (whole.options.clamped_nodes.size() != 1) return {};
  return bar_paths(whole.mesh, whole.options.clamped_nodes.front());
}

/// What is wrong with cutting this body; empty when nothing is.
std::string obstacle(const FlexibleDescription& whole, const std::vector<BarPath>& paths) {
  if (whole.options.clamped_nodes.size() != 1)
    return fmt::format("only bars that are clamped at one node can be cut into substructures; here {} are",
                       whole.options.clamped_nodes.size());
  int reached = 0;
  for (const BarPath& path : paths) reached += static_cast<int>(path.elements.size());
  if (reached < static_cast<int>(whole.mesh.elements.size()))
    return "some bars are not connected with the clamped node; bars that are cut must hang together";
  const int count = whole.substructures.count, needed = static_cast<int>(paths.size());
  if (count > reached)
    return fmt::format("{} substructures need as many elements; the bars have {}", count, reached);
  if (count < needed)
    return fmt::format(
        "{} substructures are too few: {} are needed, one for each line of bars between the nodes where "
        "they branch",
        count, needed);
  return {};
}

/// Bodies and joints of one whole as they are added to the model.
struct Assembly {
  Builder& builder;
  int body;
  const FlexibleDescription& whole;
  const std::vector<Piece>& pieces;
  std::vector<int> indices;  ///< of the bodies, by piece

  const spec::Body& first() const { return builder.model.bodies[static_cast<std::size_t>(body)]; }
  const Mark& mark() const { return first().mark; }
  std::string name_of(std::size_t piece) const { return fmt::format("{}.{}", first().name, piece + 1); }

  int add_frame(const std::string& name, int body_index, const spec::Pose& pose, int flexible_frame) {
    const int frame = builder.add_frame({name, mark(), body_index, pose, flexible_frame});
    builder.claim(builder.frame_names, builder.parts.front(), name, mark(), frame);
    return frame;
  }

  /// A new frame at the end of a piece; of no piece: at the clamped node.
  int add_end(const std::string& name, int piece) {
    if (piece < 0)
      return add_frame(
          name, body,
          {whole.mesh.nodes.col(whole.options.clamped_nodes.front()), Eigen::Matrix3d::Identity()}, -1);
    const Piece& p = pieces[static_cast<std::size_t>(piece)];
    return add_frame(name, indices[static_cast<std::size_t>(piece)],
                     {p.description.mesh.nodes.rightCols<1>(), Eigen::Matrix3d::Identity()}, p.end_frame);
  }

  void add_bracket(const std::string& name, int frame_a, int frame_b, spec::Joint::Cut cut) {
    spec::Joint bracket;
    bracket.name = name;
    bracket.mark = mark();
    bracket.type = spec::JointType::bracket;
    bracket.frame_a = frame_a;
    bracket.frame_b = frame_b;
    bracket.cut = cut;
    builder.claim(builder.joint_names, builder.parts.front(), name, mark(),
                  static_cast<int>(builder.model.joints.size()));
    builder.model.joints.push_back(std::move(bracket));
  }

  /// The body of a piece after the first, and the bracket that holds it.
  void add_body(std::size_t k) {
    spec::Body added;
    added.name = name_of(k);
    added.mark = mark();
    added.pose = {first().pose.position + first().pose.rotation * pieces[k].origin, first().pose.rotation};
    BodyInfo info;
    info.flexible = true;
    info.description = pieces[k].description;
    const int index = static_cast<int>(builder.model.bodies.size());
    builder.claim(builder.body_names, builder.parts.front(), added.name, mark(), index);
    builder.model.bodies.push_back(std::move(added));
    builder.bodies.push_back(std::move(info));
    indices.push_back(index);
    const std::string bracket = name_of(k) + ".bracket";
    const int a = add_end(bracket + ".a", pieces[k].before);
    add_bracket(bracket, a, add_frame(name_of(k), index, {}, -1), spec::Joint::Cut::automatic);
  }

  /// The bracket that joins the end of a piece to the piece that carries its last node: a loop is cut there.
  void close(std::size_t k) {
    const int node = pieces[k].nodes.back();
    int carrier = static_cast<int>(pieces.size()) - 1;  // none, -1: the node is the clamped one
    while (carrier >= 0 && (pieces[static_cast<std::size_t>(carrier)].closes ||
                            pieces[static_cast<std::size_t>(carrier)].nodes.back() != node))
      --carrier;
    const std::string closing = (k == 0 ? first().name : name_of(k)) + ".closing";
    const int a = add_end(closing + ".a", carrier);
    add_bracket(closing, a, add_end(closing + ".b", static_cast<int>(k)), spec::Joint::Cut::always);
  }
};

/// The bodies after the first, and the brackets that hold them. Returns the bodies' indices.
std::vector<int> add_bodies(Builder& builder, int body, const FlexibleDescription& whole,
                            const std::vector<Piece>& pieces) {
  Assembly assembly{builder, body, whole, pieces, {body}};
  builder.bodies[static_cast<std::size_t>(body)].description = pieces.front().description;
  for (std::size_t k = 1; k < pieces.size(); ++k) assembly.add_body(k);
  for (std::size_t k = 0; k < pieces.size(); ++k)
    if (pieces[k].closes) assembly.close(k);
  return assembly.indices;
}

/// Frames at nodes go to the piece that carries the node; the piece that ends at a cut carries the cut's
/// node.
void move_frames(Builder& builder, int body, int frames, const FlexibleDescription& whole,
                 const std::vector<Piece>& pieces, const std::vector<int>& indices) {
  for (int f = 0; f < frames; ++f) {
    spec::Frame& frame = builder.model.frames[static_cast<std::size_t>(f)];
    if (frame.body != body || frame.flexible_frame < 0) continue;
    const fe::NodeFrame& node = whole.frames[static_cast<std::size_t>(frame.flexible_frame)];
    for (std::size_t p = 0; p < pieces.size(); ++p) {
      const auto& known = pieces[p].description.frames;
      const auto found = std::find_if(known.begin(), known.end(), [&](const fe::NodeFrame& n) {
        return pieces[p].nodes[static_cast<std::size_t>(n.node)] == node.node;
      });
      if (found == known.end()) continue;
      frame.body = indices[p];
      frame.pose.position -= pieces[p].origin;
      frame.flexible_frame = static_cast<int>(found - known.begin());
      break;
    }
  }
}

/// The mass is that of all pieces; amplitudes count through the pieces; what deflects beyond the first piece
/// is seen from the whole's frame.
void move_outputs(Builder& builder, int body, int outputs_frame, const std::vector<Piece>& pieces,
                  const std::vector<int>& indices) {
  for (spec::Output& output : builder.model.outputs) {
    const OutputInfo& kind = output_info(output);
    if (kind.modes && output.item == body) {
      std::size_t p = pieces.size() - 1;
      while (output.component < pieces[p].first_mode) --p;
      output.item = indices[p];
      output.component -= pieces[p].first_mode;
    }
    if (std::find(output.bodies.begin(), output.bodies.end(), body) != output.bodies.end())
      output.bodies.insert(output.bodies.end(), indices.begin() + 1, indices.end());
    if (kind.seen_from_elsewhere.empty() || output.item < 0) continue;
    const spec::Frame& frame = builder.model.frames[static_cast<std::size_t>(output.item)];
    const auto piece = std::find(indices.begin() + 1, indices.end(), frame.body);
    if (piece == indices.end()) continue;
    output.kind = kind.seen_from_elsewhere;
    output.reference = outputs_frame;
    output.offset = -output.direction.dot(pieces[static_cast<std::size_t>(piece - indices.begin())].origin +
                                          frame.pose.position);
  }
}

}  // namespace

int mode_count(const FlexibleDescription& description) {
  const fe::ReductionOptions& o = description.options;
  const int elements = static_cast<int>(description.mesh.elements.size());
  if (description.kind == BeamKind::ancf) return 4 * elements + 1;
  if (description.kind == BeamKind::ancf_cable) return 6 * elements + 1;
  if (description.kind == BeamKind::ancf_thick) return 18 * elements;
  if (!description.in_pieces())
    return static_cast<int>(o.boundary.size()) + o.dynamic_modes + o.axial_dynamic_modes;
  const auto paths = paths_of(description);
  if (!obstacle(description, paths).empty()) return 0;
  const auto pieces = make_pieces(description, paths);
  return pieces.back().first_mode + mode_count(pieces.back().description);
}

void split_bodies(Builder& builder) {
  const std::size_t count = builder.bodies.size();
  for (std::size_t k = 0; k < count; ++k) {
    if (!builder.bodies[k].description || !builder.bodies[k].description->in_pieces()) continue;
    const FlexibleDescription whole = *builder.bodies[k].description;
    const auto paths = paths_of(whole);
    if (const std::string message = obstacle(whole, paths); !message.empty()) {
      builder.errors.add(whole.substructures.mark, fmt::format("{}: {}", whole.what, message));
      continue;
    }
    const int body = static_cast<int>(k), frames = static_cast<int>(builder.model.frames.size());
    const std::vector<Piece> pieces = make_pieces(whole, paths);
    const std::vector<int> indices = add_bodies(builder, body, whole, pieces);
    move_frames(builder, body, frames, whole, pieces, indices);
    move_outputs(builder, body, builder.frame_names.index.at(builder.model.bodies[k].name), pieces, indices);
  }
}

}  // namespace mimbre::model_file
