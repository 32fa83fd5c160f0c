#include "simulation/observe/element_channels.h"

#include <fmt/format.h>

#include "outputs/element.h"
#include "outputs/wheel_quantities.h"

namespace mimbre {
namespace {

const std::string& tyre_name(const Compiled& m, int element) {
  return m.spec().tyres[static_cast<std::size_t>(element - m.first_tyre)].name;
}

/// What a load exerts at all: it has channels only where that is not nothing.
const Vec3d& given(const ElementData& load, bool moment) { return moment ? load.second : load.direction; }

}  // namespace

void add_spring_info(const Compiled& m, int element, std::vector<ChannelInfo>& info) {
  const std::string& name = m.spec().springs[static_cast<std::size_t>(element)].name;
  info.push_back({fmt::format("spring.{}.force", name), "N", fmt::format("tension of spring '{}'", name)});
  info.push_back({fmt::format("spring.{}.length", name), "m", fmt::format("length of spring '{}'", name)});
}

void read_spring(const ElementState<const double>& s, double* to) {
  to[0] = s.force[0];
  to[1] = s.x[0];
}

void add_tyre_info(const Compiled& m, int element, std::vector<ChannelInfo>& info) {
  const std::string& name = tyre_name(m, element);
  info.push_back(
      {fmt::format("tyre.{}.vertical", name), "N", fmt::format("vertical force of tyre '{}'", name)});
}

void add_wheel_info(const Compiled& m, int element, std::vector<ChannelInfo>& info) {
  const std::string& name = tyre_name(m, element);
  for (const WheelQuantity& q : wheel_quantities)
    info.push_back(
        {fmt::format("tyre.{}.{}", name, q.name), q.unit, fmt::format(fmt::runtime(q.meaning), name)});
}

void add_road_info(const Compiled& m, int element, std::vector<ChannelInfo>& info) {
  const std::string& name = tyre_name(m, element);
  info.push_back(
      {fmt::format("tyre.{}.road", name), "m", fmt::format("global z of the road under tyre '{}'", name)});
}

void add_load_info(const Compiled& m, int element, std::vector<ChannelInfo>& info) {
  const ElementData& load = m.elements[element];
  const std::string& name = m.spec().loads[static_cast<std::size_t>(load.spec)].name;
  for (const bool moment : {false, true})
    for (int axis = 0; axis < 3 && !given(load, moment).isZero(0); ++axis) {
      const char* const what = moment ? "moment" : "force";
      info.push_back({fmt::format("load.{}.{}.{}", name, what, axis_words[axis]), moment ? "N m" : "N",
                      fmt::format("{} of load '{}', {} of the global axes", what, name, axis_words[axis])});
    }
}

void read_load(const ElementData& load, const ElementState<const double>& s, double* to) {
  for (const bool moment : {false, true}) {
    if (given(load, moment).isZero(0)) continue;
    Vec3d::Map(to) = -s.force[0] * (moment ? s.angular_of(0) : s.linear_of(0));
    to += 3;
  }
}

void add_element_info(const Compiled& m, int element, std::vector<ChannelInfo>& info) {
  const ElementData& e = m.elements[element];
  const spec::Element& s = m.spec().elements[static_cast<std::size_t>(element - m.first_other)];
  const std::string of = fmt::format("{}.{}", s.law, s.name), who = element_name(m, e);
  for (int c = 0; c < e.count; ++c) {
    const outputs::ComponentNames called = outputs::component_names(e, c);
    info.push_back({fmt::format("{}.force{}", of, called.name), called.force,
                    fmt::format("force of {}, positive where it drives what it measures on", who)});
    info.push_back(
        {fmt::format("{}.measure{}", of, called.name), called.measure, fmt::format("what {} measures", who)});
  }
}

void read_element(const ElementState<const double>& s, double* to) {
  for (int c = 0; c < s.count; ++c) {
    *to++ = -s.force[c];
    *to++ = s.x[c];
  }
}

}  // namespace mimbre
