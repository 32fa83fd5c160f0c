#include "analysis/observed_rows.h"

#include "simulation/describe/body_drawings.h"
#include "simulation/describe/element_drawings.h"

namespace mimbre {

ObservedRows::ObservedRows(const Compiled& model, bool reactions) : model_(model), channels_(model) {
  using Kind = Channels::Part::Kind;
  for (const Channels::Part& part : channels_.parts()) {
    if (part.kind == Kind::energy || part.kind == Kind::event || part.kind == Kind::solver) continue;
    if (reactions || part.needs == Channels::Needs::motion) parts_.push_back(part);
  }
}

ResultsHeader ObservedRows::header(const std::string& options_json) const {
  ResultsHeader h;
  h.title = model_.spec().title;
  h.model_text = model_.spec().text;
  h.options_json = options_json;
  for (const Channels::Part& part : parts_)
    for (int k = 0; k < part.count; ++k)
      h.channels.push_back(channels_.info()[static_cast<std::size_t>(part.first + k)]);
  h.bodies = body_drawings(model_.spec());
  h.roads = channels_.roads();
  ElementDrawings drawn = element_drawings(model_, h.bodies);
  h.frames = std::move(drawn.frames);
  h.elements = std::move(drawn.elements);
  return h;
}

ResultsRow ObservedRows::row(relative::RelativeSystem& system, const State& state) const {
  ResultsRow row;
  Eigen::VectorXd all(static_cast<Eigen::Index>(channels_.info().size()));
  std::vector<double> values;
  for (const Channels::Part& part : parts_) {
    channels_.read(part, system, state, {}, {}, all.data());
    for (int k = 0; k < part.count; ++k) values.push_back(all[part.first + k]);
  }
  row.channels = Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
  channels_.picture(system, state, row);
  return row;
}

}  // namespace mimbre
