#include <gmock/gmock.h>
#include <array>
#include <cmath>

#include <numbers>
#include <sstream>

#include "mimbre/model_file.h"
#include "model_file/text/expression.h"

/// Numbers with units: what they are in SI, and where they do not fit.
namespace mimbre::model_file::units_test {
namespace {

using std::numbers::pi;
using ::testing::HasSubstr;

double value(const std::string& text, const Quantity& of) { return evaluate(text, Scope{}, of); }

std::string complaint(const std::string& text, const Quantity& of, const Scope& scope = {}) {
  try {
    evaluate(text, scope, of);
  } catch (const ExpressionError& error) {
    return error.what();
  }
  return "nothing";
}

/// Written in SI by hand.
TEST(Units, AreTheirSiNumbers) {
  EXPECT_EQ(value("0.2 kg", quantity::mass), 0.2);
  EXPECT_EQ(value("200 g", quantity::mass), 0.2);
  EXPECT_EQ(value("5 mm", quantity::length), 0.005);  // the nearest number, not 5 times the nearest to 0.001
  EXPECT_EQ(value("7mm", quantity::length), 0.007);
  EXPECT_EQ(value("-3 cm", quantity::length), -0.03);
  EXPECT_EQ(value("12 µm", quantity::length), 12e-6);
  EXPECT_DOUBLE_EQ(value("1 ft", quantity::length), 12 * 0.0254);
  EXPECT_DOUBLE_EQ(value("30 deg", quantity::angle), pi / 6);
  EXPECT_DOUBLE_EQ(value("30°", quantity::angle), pi / 6);
  EXPECT_DOUBLE_EQ(value("10 rpm", quantity::turning_speed), 10 * 2 * pi / 60);
  EXPECT_DOUBLE_EQ(value("60 deg/s", quantity::turning_speed), pi / 3);
  EXPECT_EQ(value("2 kN/m", quantity::stiffness), 2000);
  EXPECT_EQ(value("2 N/mm", quantity::stiffness), 2000);
  EXPECT_EQ(value("3 N*s/mm", quantity::damping), 3000);
  EXPECT_EQ(value("3 Ns/m", quantity::damping), 3);
  EXPECT_EQ(value("210 GPa", quantity::pressure), 210e9);
  EXPECT_DOUBLE_EQ(value("7.85 g/cm^3", quantity::density), 7850);
  EXPECT_DOUBLE_EQ(value("7.85 g/cm³", quantity::density), 7850);
  EXPECT_DOUBLE_EQ(value("12 cm4", quantity::second_moment), 12e-8);
  EXPECT_DOUBLE_EQ(value("4 kg*mm^2", quantity::inertia), 4e-6);
  EXPECT_DOUBLE_EQ(value("4 kg·mm²", quantity::inertia), 4e-6);
  EXPECT_EQ(value("100 Nm/rad", quantity::turning_stiffness), 100);
  EXPECT_EQ(value("100 Nm", quantity::turning_stiffness), 100);
  EXPECT_EQ(value("100 N m/rad", quantity::turning_stiffness), 100);
  EXPECT_EQ(value("1.5 km", quantity::length), 1500);
  EXPECT_EQ(value("2 ms", quantity::time), 0.002);
  EXPECT_EQ(value("1e3 mm", quantity::length), 1);
}

TEST(Units, GoIntoExpressions) {
  EXPECT_DOUBLE_EQ(value("1 m - 20 mm", quantity::length), 0.98);
  EXPECT_DOUBLE_EQ(value("3/4 * 1 in", quantity::length), 0.75 * 0.0254);
  EXPECT_DOUBLE_EQ(value("0.2 m*sin(30 deg)", quantity::length), 0.1);
  EXPECT_DOUBLE_EQ(value("0.2*sin(30 deg)", quantity::length), 0.1);
  EXPECT_DOUBLE_EQ(value("2 kg * 9.81 m/s^2", quantity::force), 19.62);
  EXPECT_DOUBLE_EQ(value("(2 mm)^2", quantity::area), 4e-6);
  EXPECT_DOUBLE_EQ(value("2 kN/m * (30 cm - 50 mm)", quantity::force), 500);
  EXPECT_DOUBLE_EQ(value("1 < 2 ? 30 deg : 1", quantity::angle), pi / 6);
  EXPECT_DOUBLE_EQ(value("max(1 cm, 3 mm)", quantity::length), 0.01);
  Scope scope;
  scope.values["length"] = 0.5;
  EXPECT_DOUBLE_EQ(evaluate("length - 20 mm", scope, quantity::length), 0.48);
  EXPECT_DOUBLE_EQ(evaluate("2 kN/m*length", scope, quantity::force), 1000);
  EXPECT_EQ(value("5 kN", quantity::any), 5000);
}

/// Of a motor: volts, amperes and ohms go together with newton metres and watts.
TEST(Units, OfElectricity) {
  const Quantity resistance{"ohm", Dimension{1, 2, -3, 0, -2}},
      per_current{"N m/A", Dimension{1, 2, -2, 0, -1}}, current{"A", Dimension{0, 0, 0, 0, 1}};
  EXPECT_EQ(value("800 mohm", resistance), 0.8);
  EXPECT_EQ(value("0.8 Ω", resistance), 0.8);
  EXPECT_EQ(value("1.6 V/A * 0.5", resistance), 0.8);
  EXPECT_DOUBLE_EQ(value("50 mV s/rad", per_current), 0.05);
  EXPECT_EQ(value("0.05 N m/A", per_current), 0.05);
  EXPECT_DOUBLE_EQ(value("24 V / 2 ohm", current), 12);
  EXPECT_DOUBLE_EQ(value("12 V * 2 A / (3 rad/s)", quantity::moment), 8);
  EXPECT_THAT(complaint("15 V", current), HasSubstr("'15 V' is in kg m^2/s^3/A; A is needed here"));

  const auto motor = [](const std::string& numbers) {
    const spec::Model model = parse_model(R"yaml(mimbre: 1
bodies: {wheel: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}
joints: {axle: {type: revolute, between: [ground, wheel], at: [0, 0, 0], axis: [0, 0, 1]}}
motors: {drive: {joint: axle, voltage: 24, )yaml" +
                                              numbers + "}}\n",
                                          "motor.yaml", "");
    return model.elements[0].numbers;
  };
  EXPECT_EQ(motor("constant: 50 mN*m/A, resistance: 800 mohm, current_limit: 15000 mA"),
            motor("constant: 0.05, resistance: 0.8, current_limit: 15"));
  EXPECT_THROW(motor("constant: 0.05 N m, resistance: 0.8"), InputError);
  EXPECT_THROW(motor("constant: 0.05, resistance: 0.8 V"), InputError);
}

/// The units that messages propose: each can be read and is one of what the key measures.
TEST(Units, ThatAreProposedFit) {
  using namespace quantity;
  for (const Quantity& q : {mass, length, area, second_moment, quantity::time, angle, speed, turning_speed,
                            acceleration, turning_acceleration, force, moment, pressure, density, inertia,
                            stiffness, turning_stiffness, damping, turning_damping}) {
    EXPECT_EQ(value("2.5 " + std::string(q.unit), q), 2.5) << q.unit;  // the SI unit
    EXPECT_FALSE(q.others.empty()) << q.unit;
    std::istringstream others{std::string(q.others)};
    for (std::string unit; std::getline(others >> std::ws, unit, ',');)
      EXPECT_GT(value("2 " + unit, q), 0) << unit;
  }
}

TEST(Units, ThatDoNotFitAreToldWithTheOneThatDoes) {
  EXPECT_THAT(complaint("800 t", quantity::mass), HasSubstr("'t' is no unit; kg is needed here (or g, lb)"));
  EXPECT_THAT(complaint("7.85 t/m^3", quantity::density), HasSubstr("kg/m^3 is needed here (or g/cm^3)"));
  EXPECT_THAT(complaint("2 kN", quantity::damping), HasSubstr("N s/m is needed here (or kN s/m, N s/mm)"));
  EXPECT_THAT(complaint("3 N*(2 m)", quantity::force), HasSubstr("is in N m; N is needed here (or kN, lbf)"));
  EXPECT_THAT(complaint("0.2 kg", quantity::length), HasSubstr("'0.2 kg' is in kg; m is needed here"));
  EXPECT_THAT(complaint("30 deg", quantity::length), HasSubstr("is in rad; m is needed"));
  EXPECT_THAT(complaint("30 mm", quantity::angle), HasSubstr("is in m; rad is needed here (or deg)"));
  EXPECT_THAT(complaint("0.3 kg", quantity::number), HasSubstr("a number without unit is needed"));
  EXPECT_THAT(complaint("30 deg", quantity::number), HasSubstr("a number without unit is needed"));
  EXPECT_THAT(complaint("1 m + 2 kg", quantity::length), HasSubstr("m and kg cannot be added"));
  EXPECT_THAT(complaint("1/2 mm", quantity::length), HasSubstr("is in 1/m; m is needed"));
  EXPECT_THAT(complaint("30 deg*2 s", quantity::angle), HasSubstr("rad is needed"));
  EXPECT_THAT(complaint("5 kgg", quantity::mass), HasSubstr("'kgg' is no unit (did you mean 'kg'?)"));
  EXPECT_THAT(complaint("5 furlongs", quantity::length), HasSubstr("'furlongs' is no unit"));
  EXPECT_THAT(complaint("2 pi", quantity::angle), HasSubstr("an operator is missing before 'pi'"));
  EXPECT_THAT(complaint("1 m < 2 kg ? 1 m : 2 m", quantity::length), HasSubstr("cannot be compared"));
}

TEST(Units, InPowersAndFunctionsAreChecked) {
  const auto wrong = [](const std::string& text, const std::string& message, const Quantity& of) {
    EXPECT_THAT(complaint(text, of), HasSubstr(message)) << text;
  };
  const Quantity number = quantity::number, length = quantity::length;
  wrong("2^3 mm", "'2^3 mm': the exponent '3 mm' is in m; an exponent is a number", length);
  wrong("2^(3 kg)", "the exponent '(3 kg)' is in kg", number);
  wrong("2 + 5*2^-3 s", "the exponent '-3 s' is in s", number);
  wrong("sin(3 mm)", "the argument of sin '3 mm' is in m; a number or an angle is needed there", number);
  wrong("exp(1 kg)", "the argument of exp '1 kg' is in kg", number);
  wrong("log(2 m)", "the argument of log '2 m' is in m", number);
  wrong("1 m*cos(2 rad/s)", "the argument of cos '2 rad/s' is in rad/s", length);
  wrong("rint(3.2 mm)", "the argument of rint '3.2 mm' is in m", number);
  wrong("atan2(1 m, 1 kg)", "m and kg cannot be arguments of one atan2", number);
  wrong("max(1 m, 1 kg)", "m and kg cannot be arguments of one max", length);
  wrong("1 m && 1 kg", "the condition '1 m' is in m; a condition compares", number);
  wrong("1 < 2 || 3 kg", "the condition '3 kg' is in kg", number);
  wrong("5 mm ? 1 m : 2 m", "the condition '5 mm' is in m", length);
  wrong("1 m < 2 m && 1 s > 2 kg", "s and kg cannot be compared", number);
  wrong("sqrt(4 m^2)", "is in m; a number without unit is needed", number);
}

/// Written in SI by hand.
TEST(Units, InPowersAndFunctionsThatFit) {
  EXPECT_DOUBLE_EQ(value("(2^3)*1 mm", quantity::length), 0.008);
  EXPECT_DOUBLE_EQ(value("1 m*2^(1 m/(2 m))", quantity::length), std::sqrt(2.0));
  EXPECT_DOUBLE_EQ(value("(2 mm)^2*(3 mm)^-1", quantity::length), 4e-6 / 3e-3);
  EXPECT_DOUBLE_EQ(value("exp(0.3*180 deg)", quantity::number), std::exp(0.3 * pi));
  EXPECT_DOUBLE_EQ(value("exp(-(3 s - 2 s)/0.5 s)", quantity::number), std::exp(-2.0));
  EXPECT_DOUBLE_EQ(value("atan2(1 m, 10 cm)", quantity::angle), std::atan2(1, 0.1));
  EXPECT_DOUBLE_EQ(value("sqrt(4 mm^2)", quantity::length), 0.002);
  EXPECT_DOUBLE_EQ(value("sqrt(2*9.81 m/s^2*1 m)", quantity::speed), std::sqrt(19.62));
  EXPECT_DOUBLE_EQ(value("1 m < 2 m && 1 s < 2 s ? 3 mm : 4 mm", quantity::length), 0.003);
  EXPECT_EQ(value("sign(-3 mm)*2", quantity::number), -2);
  // What has no unit beside it is SI.
  const auto law = [](const std::string& text) {
    const std::vector<Variable> variables = variables_of(LawOf::all);
    return substitute_parameters(text, Scope{}, variables, quantity::force);
  };
  EXPECT_NO_THROW(law("5 N*sin(2*t)*exp(-l) + 2 N"));
  EXPECT_NO_THROW(law("l > 2 cm && v < 0 ? 5 N : 0"));
  EXPECT_NO_THROW(law("5 N*sin(3 rad/s*t)"));
  EXPECT_THROW(law("5 N*sin(t + 1 s)"), ExpressionError);
  EXPECT_THROW(law("l > 2 s && v < 0 ? 5 N : 0"), ExpressionError);
}

/// The micro sign (U+00B5) and the Greek letter (U+03BC).
TEST(Units, HaveMicroInEitherLetter) {
  for (const std::string micro : {"\u00B5", "\u03BC", "u"}) {
    EXPECT_EQ(value("12 " + micro + "m", quantity::length), 12e-6);
    EXPECT_EQ(value("10 " + micro + "s", quantity::time), 1e-5);
  }
}

/// `m`, `g`, `s` are names that parameters have.
TEST(Units, AreNotMistakenForParameters) {
  Scope scope;
  scope.values["m"] = 3.0;
  EXPECT_EQ(evaluate("2*m", scope, quantity::mass), 6);
  EXPECT_EQ(evaluate("2 m", scope, quantity::length), 2);
  EXPECT_DOUBLE_EQ(evaluate("6 N / m", scope, quantity::force), 2);
  EXPECT_THAT(complaint("6 N/m", quantity::stiffness, scope), HasSubstr("'m' could be the unit"));
}

const std::string si = R"yaml(mimbre: 1
gravity: [0, 0, -9.81]
parameters: {length: 0.5}
bodies:
  arm: {mass: 0.2, com: [0.25, 0, 0], inertia: [1e-5, 2e-3, 2e-3]}
  cart: {mass: 1, com: [0, 0, 1], inertia: [1, 1, 1]}
joints:
  hinge: {type: revolute, between: [ground, arm], at: [0, 0, 0], axis: [0, 1, 0],
          drive: {position: "pi/6*sin(2*pi*t)"}}
  rail: {type: prismatic, between: [ground, cart], at: [0, 0, 1], axis: [1, 0, 0], position: 0.03, velocity: 0.5,
         spring: {stiffness: 2000, damping: 30, zero: 0.01}}
springs:
  coil: {between: [arm, cart], at: [[length, 0, 0], [0, 0, 1]], elastic: {stiffness: 1500, zero: 0.8}, damping: 20}
outputs:
  - {name: angle, joint: hinge, offset: pi/2}
simulation: {step: 0.001, end: 2}
)yaml";
const std::string with_units = R"yaml(mimbre: 1
gravity: [0, 0, -9.81 m/s^2]
parameters: {length: 500 mm}
bodies:
  arm: {mass: 200 g, com: [25 cm, 0, 0], inertia: [10 kg*mm^2, 2000 kg*mm^2, 2e-3]}
  cart: {mass: 1 kg, com: [0, 0, 1 m], inertia: [1, 1, 1]}
joints:
  hinge: {type: revolute, between: [ground, arm], at: [0, 0, 0], axis: [0, 1, 0],
          drive: {position: "30 deg*sin(360 deg/s*t)"}}
  rail: {type: prismatic, between: [ground, cart], at: [0, 0, 100 cm], axis: [1, 0, 0], position: 30 mm, velocity: 50 cm/s,
         spring: {stiffness: 2 N/mm, damping: 30 Ns/m, zero: 1 cm}}
springs:
  coil: {between: [arm, cart], at: [[length, 0, 0], [0, 0, 1]], elastic: {stiffness: 1.5 kN/m, zero: 80 cm},
         damping: 20 N*s/m}
outputs:
  - {name: angle, joint: hinge, offset: 90 deg}
simulation: {step: 1 ms, end: 2 s}
)yaml";

TEST(Units, OfAModelMakeTheSameModel) {
  const spec::Model a = parse_model(si, "a.yaml", ""), b = parse_model(with_units, "b.yaml", "");
  EXPECT_EQ(a.gravity, b.gravity);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_EQ(a.bodies[k].mass, b.bodies[k].mass);
    EXPECT_TRUE(a.bodies[k].inertia.isApprox(b.bodies[k].inertia, 1e-15));
    EXPECT_EQ(a.bodies[k].pose.position, b.bodies[k].pose.position);
  }
  for (const double t : {0.0, 0.1, 0.77})
    EXPECT_NEAR(a.joints[0].drives[0].law.value(t), b.joints[0].drives[0].law.value(t), 1e-15);
  EXPECT_EQ(a.joints[1].initial_position, b.joints[1].initial_position);
  EXPECT_EQ(a.joints[1].initial_velocity, b.joints[1].initial_velocity);
  EXPECT_DOUBLE_EQ(a.joints[1].springs[0].elastic.value(0.2), b.joints[1].springs[0].elastic.value(0.2));
  EXPECT_DOUBLE_EQ(a.joints[1].springs[0].damping.value(0.2), b.joints[1].springs[0].damping.value(0.2));
  EXPECT_DOUBLE_EQ(a.springs[0].elastic.value(0.9), b.springs[0].elastic.value(0.9));
  EXPECT_DOUBLE_EQ(a.springs[0].damping.value(0.9), b.springs[0].damping.value(0.9));
  EXPECT_DOUBLE_EQ(a.outputs[0].offset, b.outputs[0].offset);
  EXPECT_EQ(a.simulation.step, b.simulation.step);
  EXPECT_EQ(a.simulation.end, b.simulation.end);
}

/// Every law of a spring, with and without units.
TEST(Units, OfLawsAreThoseOfTheirVariables) {
  const auto coil = [](const std::string& law) {
    std::string text = si;
    const std::string given = "elastic: {stiffness: 1500, zero: 0.8}, damping: 20";
    text.replace(text.find(given), given.size(), law);
    return parse_model(text, "law.yaml", "").springs[0];
  };
  EXPECT_DOUBLE_EQ(coil("elastic: \"2 kN/m*(l - 25 cm)\"").elastic.value(0.5), 500);
  EXPECT_DOUBLE_EQ(coil("elastic: {table: [[0 mm, 0 kN], [10 mm, 1 kN]]}").elastic.value(0.005), 500);
  EXPECT_DOUBLE_EQ(coil("elastic: {constant: 2 kN}").elastic.value(1), 2000);
  EXPECT_DOUBLE_EQ(
      coil("elastic: {pieces: [{until: 10 cm, polynomial: [1]}, {polynomial: [2]}]}").elastic.value(0.05), 1);
  EXPECT_DOUBLE_EQ(coil("force: \"l > 30 cm ? 2 kN/m*(l - 30 cm) + 5 N*s/m*v : 0\"")
                       .general.formula.value(std::array{0.5, 2.0, 0.0}.data()),
                   410);
  EXPECT_DOUBLE_EQ(coil("elastic: {polynomial: [1 kN, 2 N/mm, 3 kN/m^2, 4]}").elastic.value(0.5),
                   1000 + 2000 * 0.5 + 3000 * 0.25 + 4 * 0.125);
  EXPECT_DOUBLE_EQ(coil("damping: {polynomial: [0, 2 N s/mm, 3 N s^2/m^2]}").damping.value(0.5), 1000 + 0.75);
  EXPECT_DOUBLE_EQ(coil("elastic: {pieces: [{until: 10 cm, polynomial: [1 kN]}, {polynomial: [0, 2 kN/m]}]}")
                       .elastic.value(0.5),
                   1000);
  EXPECT_THROW(coil("elastic: {polynomial: [1 kN, 2 kN]}"), InputError);
  EXPECT_THROW(coil("damping: {polynomial: [0, 0, 3 N/m^2]}"), InputError);
  EXPECT_THROW(coil("elastic: \"2 kN*(l - 25 cm)\""), InputError);
  EXPECT_THROW(coil("elastic: {table: [[0 kg, 0], [1, 1]]}"), InputError);
  EXPECT_THROW(coil("damping: 20 N/m"), InputError);
}

}  // namespace
}  // namespace mimbre::model_file::units_test
