#include "compile/element_name.h"

#include <fmt/format.h>

#include "spec/force_law.h"

namespace mimbre {

std::string element_name(const Compiled& m, const ElementData& e) {
  const LawInfo& law = law_info(e.law);
  switch (law.list) {
    case SpecList::springs:
      return e.measure == Measure::coordinate
                 ? fmt::format("the spring of joint '{}'", m.spec().joints[e.joint_spec].name)
                 : fmt::format("spring '{}'", m.spec().springs[e.spec].name);
    case SpecList::tyres:
      return fmt::format("tyre '{}'", m.spec().tyres[e.spec].name);
    case SpecList::loads:
      return fmt::format("load '{}'", m.spec().loads[e.spec].name);
    case SpecList::contacts:
      return fmt::format("contact '{}'", m.spec().contacts[e.spec].name);
    case SpecList::sensors:
      return "a sensor";
    case SpecList::elements:
      break;
  }
  return fmt::format("{} '{}'", law.name, m.spec().elements[e.spec].name);
}

}  // namespace mimbre
