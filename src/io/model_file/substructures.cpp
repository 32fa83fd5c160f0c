#include <fmt/format.h>

#include <algorithm>

#include "io/model_file/builder.h"

/// Substructuring (Wu, Haug 1988; Lugrís 2008, 4.2): a beam that bends far is cut into bodies, each of which
/// bends little in its own frame, joined by brackets. With a frame for each element, and the second order of
/// its bending, this is a corotational beam.
namespace mimbre::model_file {
namespace {

/// The nodes and elements of a mesh in the order in which one walks from one end to the other.
struct Chain {
  std::vector<int> nodes;
  std::vector<int> elements;
};

/// From the clamped node. Nothing when the mesh branches, has loops, or is not held at one end alone.
std::optional<Chain> chain_of(const FlexibleDescription& whole) {
  if (whole.options.clamped_nodes.size() != 1) return {};
  const fe::Mesh& mesh = whole.mesh;
  const int start = whole.options.clamped_nodes.front();
  std::vector<std::vector<int>> elements_at(static_cast<std::size_t>(mesh.nodes.cols()));
  for (std::size_t e = 0; e < mesh.elements.size(); ++e)
    for (const int node : mesh.elements[e].nodes)
      elements_at[static_cast<std::size_t>(node)].push_back(static_cast<int>(e));
  Chain chain{{start}, {}};
  if (elements_at[static_cast<std::size_t>(start)].size() != 1) return {};
  while (chain.elements.size() < mesh.elements.size()) {
    const auto& here = elements_at[static_cast<std::size_t>(chain.nodes.back())];
    const int last = chain.elements.empty() ? -1 : chain.elements.back();
    if (here.size() > 2 || (here.size() == 1 && last >= 0)) return {};
    const int next = here.front() == last ? here.back() : here.front();
    const auto& ends = mesh.elements[static_cast<std::size_t>(next)].nodes;
    chain.elements.push_back(next);
    chain.nodes.push_back(ends[0] == chain.nodes.back() ? ends[1] : ends[0]);
  }
  return chain;
}

/// One flexible body of the chain, and where the whole body's nodes are in it.
struct Piece {
  FlexibleDescription description;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< of its frame, in the axes of the whole
  std::vector<int> nodes;                            ///< of the whole
  int end_frame = 0;                                 ///< index of the frame that carries the next piece
  int first_mode = 0;                                ///< its first amplitude among those of the whole
};

std::vector<bool> fixed_dofs(const FlexibleDescription& whole) {
  std::vector<bool> fixed(static_cast<std::size_t>(6 * whole.mesh.nodes.cols()), false);
  for (const int dof : whole.options.fixed_dofs) fixed[static_cast<std::size_t>(dof)] = true;
  return fixed;
}

/// The chain's elements [first, last) as a body that the whole body's frame (piece 0) or the bracket at its
/// first node holds.
Piece make_piece(const FlexibleDescription& whole, const Chain& chain, const std::vector<bool>& fixed,
                 int index, int first, int last) {
  Piece piece;
  const bool at_end = last == static_cast<int>(chain.elements.size());
  const bool moves_at_end = !at_end || whole.kind == BeamKind::corotational;
  FlexibleDescription& d = piece.description;
  d.mark = whole.mark;
  d.what = fmt::format("{}: substructure {}", whole.what, index + 1);
  d.line_radius = whole.line_radius;
  piece.nodes.assign(chain.nodes.begin() + first, chain.nodes.begin() + last + 1);
  if (index > 0) piece.origin = whole.mesh.nodes.col(piece.nodes.front());

  std::vector<int> local(static_cast<std::size_t>(whole.mesh.nodes.cols()), -1);
  d.mesh.nodes.resize(3, static_cast<Eigen::Index>(piece.nodes.size()));
  for (std::size_t k = 0; k < piece.nodes.size(); ++k) {
    local[static_cast<std::size_t>(piece.nodes[k])] = static_cast<int>(k);
    d.mesh.nodes.col(static_cast<Eigen::Index>(k)) = whole.mesh.nodes.col(piece.nodes[k]) - piece.origin;
  }
  for (int e = first; e < last; ++e) {
    fe::BeamElement element =
        whole.mesh.elements[static_cast<std::size_t>(chain.elements[static_cast<std::size_t>(e)])];
    for (int& node : element.nodes) node = local[static_cast<std::size_t>(node)];
    d.mesh.elements.push_back(element);
  }

  d.options = whole.options;
  d.options.clamped_nodes = {0};
  d.options.boundary.clear();
  d.options.fixed_dofs.clear();
  d.options.dynamic_modes = at_end ? whole.options.dynamic_modes : whole.substructures.dynamic_modes;
  const int end = static_cast<int>(piece.nodes.size()) - 1;
  for (int k = 1; k <= end; ++k)
    for (int dof = 0; dof < 6; ++dof) {
      if (fixed[static_cast<std::size_t>(6 * piece.nodes[static_cast<std::size_t>(k)] + dof)])
        d.options.fixed_dofs.push_back(6 * k + dof);
      else if (k == end && moves_at_end)
        d.options.boundary.push_back({end, dof > 2, Eigen::Vector3d::Unit(dof % 3),
                                      fmt::format("end.{}{}", dof > 2 ? "r" : "", "xyz"[dof % 3])});
    }
  for (fe::BoundaryDof dof : whole.options.boundary) {
    dof.node = local[static_cast<std::size_t>(dof.node)];
    // The bracket's modes hold whatever the user wants at its node.
    if (dof.node > 0 && (!moves_at_end || dof.node != end)) d.options.boundary.push_back(dof);
  }
  for (const fe::NodeFrame& frame : whole.frames)
    if (const int node = local[static_cast<std::size_t>(frame.node)]; node > 0 || (node == 0 && index == 0)) {
      d.frames.push_back(frame);
      d.frames.back().node = node;
    }
  piece.end_frame = static_cast<int>(d.frames.size());
  if (!at_end) d.frames.push_back({"end", end, Eigen::Matrix3d::Identity()});
  return piece;
}

std::vector<Piece> make_pieces(const FlexibleDescription& whole, const Chain& chain) {
  std::vector<Piece> pieces;
  const int count = whole.substructures.count, elements = static_cast<int>(chain.elements.size());
  const std::vector<bool> fixed = fixed_dofs(whole);
  for (int k = 0; k < count; ++k) {
    pieces.push_back(make_piece(whole, chain, fixed, k, k * elements / count, (k + 1) * elements / count));
    if (k > 0)
      pieces[static_cast<std::size_t>(k)].first_mode =
          pieces[static_cast<std::size_t>(k - 1)].first_mode +
          mode_count(pieces[static_cast<std::size_t>(k - 1)].description);
  }
  return pieces;
}

/// What is wrong with cutting this body; empty when nothing is.
std::string obstacle(const FlexibleDescription& whole, const std::optional<Chain>& chain) {
  if (!chain)
    return "only a chain of bars without branches, clamped at one end alone, can be cut into substructures";
  const int elements = static_cast<int>(chain->elements.size());
  if (whole.substructures.count > elements)
    return fmt::format("{} substructures need as many elements; the bars have {}", whole.substructures.count,
                       elements);
  return {};
}

/// The bodies after the first, and the brackets that hold them. Returns the bodies' indices.
std::vector<int> add_bodies(Builder& builder, int body, std::vector<Piece>& pieces) {
  spec::Model& model = builder.model;
  const Part& part = builder.parts.front();
  std::vector<int> indices{body};
  builder.bodies[static_cast<std::size_t>(body)].description = pieces.front().description;
  for (std::size_t k = 1; k < pieces.size(); ++k) {
    const spec::Body& whole = model.bodies[static_cast<std::size_t>(body)];
    const int index = static_cast<int>(model.bodies.size());
    spec::Body added;
    added.name = fmt::format("{}.{}", whole.name, k + 1);
    added.mark = whole.mark;
    added.pose = {whole.pose.position + whole.pose.rotation * pieces[k].origin, whole.pose.rotation};
    BodyInfo info;
    info.flexible = true;
    info.description = pieces[k].description;

    spec::Joint bracket;
    bracket.name = added.name + ".bracket";
    bracket.mark = whole.mark;
    bracket.type = spec::JointType::bracket;
    const spec::Pose end{pieces[k].origin - pieces[k - 1].origin, Eigen::Matrix3d::Identity()};
    bracket.frame_a =
        builder.add_frame({bracket.name + ".a", whole.mark, indices.back(), end, pieces[k - 1].end_frame});
    bracket.frame_b = builder.add_frame({added.name, whole.mark, index, {}, -1});
    builder.claim(builder.body_names, part, added.name, whole.mark, index);
    builder.claim(builder.frame_names, part, added.name, whole.mark, bracket.frame_b);
    builder.claim(builder.frame_names, part, bracket.name + ".a", whole.mark, bracket.frame_a);
    builder.claim(builder.joint_names, part, bracket.name, whole.mark, static_cast<int>(model.joints.size()));
    model.joints.push_back(std::move(bracket));
    model.bodies.push_back(std::move(added));
    builder.bodies.push_back(std::move(info));
    indices.push_back(index);
  }
  return indices;
}

/// Frames at nodes go to the piece that carries the node; the piece before a cut carries the cut's node.
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

/// Amplitudes count through the pieces; what deflects beyond the first piece is seen from the whole's frame.
void move_outputs(Builder& builder, int body, int outputs_frame, const std::vector<Piece>& pieces,
                  const std::vector<int>& indices) {
  for (spec::Output& output : builder.model.outputs) {
    if (output.kind == spec::Output::Kind::modal_amplitude && output.item == body) {
      std::size_t p = pieces.size() - 1;
      while (output.component < pieces[p].first_mode) --p;
      output.item = indices[p];
      output.component -= pieces[p].first_mode;
    }
    if (output.kind != spec::Output::Kind::deflection || output.item < 0) continue;
    const spec::Frame& frame = builder.model.frames[static_cast<std::size_t>(output.item)];
    const auto piece = std::find(indices.begin() + 1, indices.end(), frame.body);
    if (piece == indices.end()) continue;
    output.kind = spec::Output::Kind::displacement;
    output.reference = outputs_frame;
    output.offset = -output.direction.dot(pieces[static_cast<std::size_t>(piece - indices.begin())].origin +
                                          frame.pose.position);
  }
}

}  // namespace

int mode_count(const FlexibleDescription& description) {
  const fe::ReductionOptions& o = description.options;
  if (description.kind == BeamKind::ancf) return 4 * static_cast<int>(description.mesh.elements.size()) + 1;
  if (!description.in_pieces())
    return static_cast<int>(o.boundary.size()) + o.dynamic_modes + o.axial_dynamic_modes;
  const auto chain = chain_of(description);
  if (!obstacle(description, chain).empty()) return 0;
  const auto pieces = make_pieces(description, *chain);
  return pieces.back().first_mode + mode_count(pieces.back().description);
}

void split_bodies(Builder& builder) {
  const std::size_t count = builder.bodies.size();
  for (std::size_t k = 0; k < count; ++k) {
    if (!builder.bodies[k].description || !builder.bodies[k].description->in_pieces()) continue;
    const FlexibleDescription whole = *builder.bodies[k].description;
    const auto chain = chain_of(whole);
    if (const std::string message = obstacle(whole, chain); !message.empty()) {
      builder.errors.add(whole.substructures.mark, fmt::format("{}: {}", whole.what, message));
      continue;
    }
    const int body = static_cast<int>(k), frames = static_cast<int>(builder.model.frames.size());
    std::vector<Piece> pieces = make_pieces(whole, *chain);
    const std::vector<int> indices = add_bodies(builder, body, pieces);
    move_frames(builder, body, frames, whole, pieces, indices);
    move_outputs(builder, body, builder.frame_names.index.at(builder.model.bodies[k].name), pieces, indices);
  }
}

}  // namespace mimbre::model_file
