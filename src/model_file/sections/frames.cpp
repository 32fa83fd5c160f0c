#include <fmt/format.h>

#include "model_file/text/builder.h"

/// Named frames.
namespace mimbre::model_file {

void read_frames(Builder& builder, Part& part) {
  const auto section = part.section("frames");
  if (!section) return;
  if (!section->is_map()) return section->error("names with their descriptions are needed");
  for (const auto& entry : section->tree().entries) {
    const std::string name = part.full_name(entry.key);
    const Value value(part.reading, *entry.value, fmt::format("frame '{}'", name));
    const Fields fields(value, {"body", "at", "x", "y", "z"});
    const auto on = fields.need("body", "ground");
    const auto at = fields.need("at", "[0, 0, 0]");
    const spec::Pose pose = read_pose(part, fields, Eigen::Vector3d::Zero());
    int body = spec::ground;
    if (on) {
      const auto word = on->word();
      if (!word) continue;
      if (*word != "ground") {
        body = builder.resolve(builder.body_names, part, *word, *on);
        if (body < 0) continue;
      }
    }
    if (!on || !at) continue;
    const int frame = builder.add_frame_at(name, body, pose.position, pose.rotation, *at);
    builder.model.frames[static_cast<std::size_t>(frame)].mark = entry.mark;
    if (builder.body_names.index.contains(name))
      builder.errors.add(entry.mark,
                         fmt::format("frame '{}': a body has this name, and bodies and frames share their "
                                     "names; choose another",
                                     name));
    else
      builder.claim(builder.frame_names, part, name, entry.mark, frame);
  }
}

}  // namespace mimbre::model_file
