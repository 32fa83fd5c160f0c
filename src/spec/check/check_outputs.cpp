#include <algorithm>

#include "joints/joint_kind.h"
#include "mimbre/reduced_body.h"
#include "spec/check/checked_item.h"
#include "spec/output_kind.h"

/// Channels that the user named.
namespace mimbre::checks {
namespace {

using Of = OutputInfo::Of;

/// Commas and quotes would break the columns of a CSV file.
void check_name(const CheckedItem& item, const std::string& name) {
  const auto good = [](char c) {
    return static_cast<unsigned char>(c) >= 0x20 && c != ',' && c != '"' && c != 0x7f;
  };
  if (name.size() > 100 || !std::all_of(name.begin(), name.end(), good))
    item.error("is no name of a column; it has 1 to 100 characters, no comma and no quote");
  if (name == "t") item.error("'t' is the column of the time; choose another name");
}

/// What the output is of.
bool has_item(const spec::Model& model, const CheckedItem& item, Of of, int number) {
  const auto one_of = [&](const auto& list, const char* called) {
    return item.index("item", number, list.size(), called);
  };
  switch (of) {
    case Of::frame:
      return one_of(model.frames, "frames");
    case Of::joint:
      return one_of(model.joints, "joints");
    case Of::body:
      return one_of(model.bodies, "bodies");
    case Of::bodies:
      return true;
    case Of::spring:
      return one_of(model.springs, "springs");
    case Of::tyre:
      return one_of(model.tyres, "tyres");
    case Of::contact:
      return one_of(model.contacts, "contacts");
    case Of::element:
      return one_of(model.elements, "elements");
    case Of::signal:
      return one_of(model.signals, "signals");
    case Of::input:
      return one_of(model.inputs, "inputs");
  }
  return false;
}

/// How many components there are; −1: none, which has been reported.
int count_components(const spec::Model& model, const CheckedItem& item, const OutputInfo& info, int number) {
  if (info.count) {
    const spec::JointType type = model.joints[static_cast<std::size_t>(number)].type;
    if (!is_joint(type)) return -1;  // reported already
    const int count = info.count(joint_info(type));
    if (count > 0) return count;
    item.error(fmt::format("a {} joint {}", joint_info(type).name, info.without));
    return -1;
  }
  if (info.modes) {
    const spec::Body& body = model.bodies[static_cast<std::size_t>(number)];
    if (body.flexible && body.flexible->modes > 0) return body.flexible->modes;
    item.error(fmt::format("body '{}' is rigid and has no modes", body.name));
    return -1;
  }
  return static_cast<int>(info.words.size());
}

void check_output(const spec::Model& model, const CheckedItem& item, const spec::Output& output) {
  check_name(item, output.name);
  item.finite("offset", output.offset);
  const int kind = find_output(output.kind);
  if (kind < 0) return item.error(fmt::format("kind: there is no output '{}'", output.kind));
  const OutputInfo& info = *all_outputs()[static_cast<std::size_t>(kind)];
  if (!has_item(model, item, info.of, output.item)) return;
  const int count = count_components(model, item, info, output.item);
  if (count > 0 && !item.between("component", output.component, 0, count - 1)) return;
  if (info.check) info.check(model, item, output);
}

}  // namespace

void check_outputs(const spec::Model& model, std::vector<Diagnostic>& errors) {
  for (std::size_t k = 0; k < model.outputs.size(); ++k)
    check_output(model, CheckedItem(errors, "output", model.outputs[k].name, model.outputs[k].mark, k),
                 model.outputs[k]);
  for (std::size_t k = 0; k < model.sensors.size(); ++k)
    check_output(model, CheckedItem(errors, "sensor", model.sensors[k].name, model.sensors[k].mark, k),
                 model.sensors[k]);
}

}  // namespace mimbre::checks
