#include <fmt/format.h>

#include "model_file/sections/elements.h"
#include "model_file/sections/signals.h"

/// What happens when a value crosses another.
namespace mimbre::model_file {
namespace {

/// The sum of terms over time, inputs, signals and outputs.
spec::Law formula(Builder& builder, const Part& part, const std::vector<Value>& terms) {
  std::vector<FormulaTerm> of;
  for (const Value& term : terms) of.emplace_back(term, variables_of(LawOf::time));
  auto read = read_formula(builder, part, of, {"t"}, quantity::any);
  if (!read) return {};
  read->arguments.insert(read->arguments.begin(), spec::Source{});
  return std::move(*read);
}

void read_event(Builder& builder, const Part& part, const Value& value, spec::Event& event) {
  const Fields fields(value, {"when", "crosses", "direction", "set", "stop", "about"});
  if (!value.has_fields()) return;
  if (const auto when = fields.need("when", "height")) {
    std::vector<Value> terms{*when};
    Tree level = when->tree();
    if (const double crosses = fields.number("crosses", 0, quantity::any); crosses != 0) {
      level.text = fmt::format("{:.17g}", -crosses);
      terms.emplace_back(part.reading, level, when->what());
    }
    event.when = formula(builder, part, terms);
  }
  if (const auto direction = fields.get("direction"))
    event.direction =
        static_cast<spec::Event::Direction>(direction->choice({"either", "rising", "falling"}).value_or(0));
  if (const auto stop = fields.get("stop")) event.stop = stop->flag().value_or(false);
  const auto sets = fields.get("set");
  if (!sets) return;
  if (!sets->is_map()) return sets->error("inputs with their new values are needed, for example {brake: 1}");
  for (const auto& entry : sets->tree().entries) {
    const Value to(part.reading, *entry.value, fmt::format("{}: {}", value.what(), entry.key));
    const int input = builder.resolve(builder.input_names, part, entry.key, to);
    if (input >= 0) event.sets.push_back({input, formula(builder, part, {to})});
  }
}

}  // namespace

void read_events(Builder& builder, Part& part) {
  std::size_t count = builder.model.events.size();
  for_each(builder, part, "events", builder.event_names, count,
           [&](const std::string& name, const Mark& mark, const Value& value) {
             spec::Event event;
             event.name = name;
             event.mark = mark;
             read_event(builder, part, value, event);
             builder.model.events.push_back(std::move(event));
           });
}

}  // namespace mimbre::model_file
