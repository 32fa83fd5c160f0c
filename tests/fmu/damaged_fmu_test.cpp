#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "fmu/description.h"
#include "fmu/fmu_files.h"
#include "fmu/plan.h"
#include "mimbre/diagnostics.h"
#include "mimbre/fmu_import.h"

/// Files of FMUs that are damaged, or made to do harm.
namespace mimbre::test::damaged_fmus {
namespace {

using testing::HasSubstr;

std::string refusal(const std::function<void()>& work) {
  try {
    work();
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

FmuSettings unit_settings(const std::string& file) {
  FmuSettings settings;
  settings.file = file;
  settings.inputs = {"y", "r"};
  settings.outputs = {"u"};
  settings.parameters = {{"kp", "2"}};
  return settings;
}

TEST(DamagedFmus, AnyByteMayBeWrong) {
  const FmuFolder folder;
  std::mt19937_64 random(29);
  int refused = 0, read = 0;
  for (const int version : {2, 3}) {
    const std::string sound =
        zip_of({{"modelDescription.xml", unit_description(version)}, {"resources/a.txt", "abc"}});
    for (int k = 0; k < 1500; ++k) {
      std::string bytes = sound;
      for (std::uint64_t n = 1 + random() % 4; n > 0 && !bytes.empty(); --n) {
        const std::size_t at = random() % bytes.size();
        switch (random() % 4) {
          case 0:
            bytes[at] = static_cast<char>(random());
            break;
          case 1:
            bytes.resize(at + 1);
            break;
          case 2:
            bytes.erase(at, random() % 16);
            break;
          default:
            bytes.insert(at, bytes.substr(random() % bytes.size(), random() % 16));
        }
      }
      const std::string file = folder.write("damaged.fmu", bytes);
      try {
        load_fmu(unit_settings(file));
        ++read;
      } catch (const InputError& error) {
        EXPECT_THAT(error.what(), HasSubstr("damaged.fmu"));
        ++refused;
      }
    }
  }
  EXPECT_GT(refused, 2500);
  EXPECT_LT(read, 500);
}

TEST(DamagedFmus, AnyByteOfTheDescriptionMayBeWrong) {
  std::mt19937_64 random(30);
  for (const int version : {2, 3}) {
    const std::string sound = unit_description(version);
    for (int k = 0; k < 5000; ++k) {
      std::string xml = sound;
      for (std::uint64_t n = 1 + random() % 3; n > 0; --n)
        xml[random() % xml.size()] = static_cast<char>(random());
      refusal([&] { fmu::read_description(xml, "a.fmu"); });  // or it is read
    }
  }
}

TEST(DamagedFmus, MembersStayInTheirFolder) {
  const FmuFolder folder;
  for (const std::string name :
       {"../evil", "resources/../../evil", "/etc/evil", "resources\\..\\evil", "c:evil"}) {
    const std::string file =
        folder.write("evil.fmu", zip_of({{"modelDescription.xml", unit_description(2)}, {name, "x"}}));
    EXPECT_THAT(refusal([&] { load_fmu(unit_settings(file)); }), HasSubstr("outside of its folder")) << name;
  }
  const std::string twice = folder.write(
      "twice.fmu",
      zip_of({{"modelDescription.xml", unit_description(2)}, {"resources/a", "x"}, {"resources/a", "y"}}));
  EXPECT_THAT(refusal([&] { load_fmu(unit_settings(twice)); }), HasSubstr("two members 'resources/a'"));
}

TEST(DamagedFmus, SizesThatLieAreRefused) {
  const FmuFolder folder;
  std::string bytes = zip_of({{"modelDescription.xml", unit_description(2)}});
  // The size in the directory: "stored" members have one size.
  const std::size_t directory = bytes.rfind("PK\x01\x02");
  bytes[directory + 24 + 3] = 0x7f;
  const std::string file = folder.write("large.fmu", bytes);
  EXPECT_THAT(refusal([&] { load_fmu(unit_settings(file)); }), HasSubstr("is damaged"));
}

TEST(DamagedFmus, DescriptionsThatLieAreRefused) {
  const auto read = [](const std::string& inside, const std::string& version = "3.0") {
    return refusal([&] {
      fmu::read_description("<fmiModelDescription fmiVersion=\"" + version +
                                "\" modelName=\"m\" instantiationToken=\"t\"><CoSimulation "
                                "modelIdentifier=\"m\"/><ModelVariables>" +
                                inside + "</ModelVariables></fmiModelDescription>",
                            "a.fmu");
    });
  };
  EXPECT_EQ(read("<Float64 name=\"x\" valueReference=\"1\"/>"), "accepted");
  EXPECT_THAT(read("<Float64 name=\"x\" valueReference=\"-1\"/>"), HasSubstr("no whole number"));
  EXPECT_THAT(read("<Float64 name=\"x\" valueReference=\"4294967296\"/>"), HasSubstr("no whole number"));
  EXPECT_THAT(read("<Float64 name=\"x\" valueReference=\"1\"/><Float64 name=\"x\" valueReference=\"2\"/>"),
              HasSubstr("two variables 'x'"));
  EXPECT_THAT(
      read("<Float64 name=\"x\" valueReference=\"1\"><Dimension start=\"99999999999999999999\"/></Float64>"),
      HasSubstr("dimension"));
  EXPECT_THAT(read("<Float64 name=\"x\" valueReference=\"1\"><Dimension start=\"100000\"/><Dimension "
                   "start=\"100000\"/></Float64>"),
              HasSubstr("more than"));
  EXPECT_THAT(read("<Float64 name=\"x\" valueReference=\"1\"><Dimension valueReference=\"7\"/></Float64>"),
              HasSubstr("structural parameter"));
  EXPECT_THAT(read("", "1.0"), HasSubstr("2.0 and 3.0 are read"));
  EXPECT_THAT(refusal([] { fmu::read_description("<a/>", "a.fmu"); }), HasSubstr("fmiModelDescription"));
  EXPECT_THAT(refusal([] {
                fmu::read_description(
                    "<fmiModelDescription fmiVersion=\"2.0\"><CoSimulation "
                    "modelIdentifier=\"../m\"/></fmiModelDescription>",
                    "a.fmu");
              }),
              HasSubstr("no name of a file"));
}

TEST(DamagedFmus, ElementsOfArraysAreFound) {
  const FmuFolder folder;
  const std::string xml =
      "<fmiModelDescription fmiVersion=\"3.0\" modelName=\"m\" instantiationToken=\"t\"><CoSimulation "
      "modelIdentifier=\"m\"/><ModelVariables><UInt64 name=\"n\" valueReference=\"1\" "
      "causality=\"structuralParameter\" start=\"3\"/><Float64 name=\"y\" valueReference=\"2\" "
      "causality=\"output\"><Dimension valueReference=\"1\"/><Dimension start=\"2\"/></Float64>"
      "</ModelVariables></fmiModelDescription>";
  const std::string file = folder.write("array.fmu", zip_of({{"modelDescription.xml", xml}}));
  const auto with = [&](const std::string& name) {
    FmuSettings settings;
    settings.file = file;
    settings.outputs = {name};
    return refusal([&] { load_fmu(settings); });
  };
  EXPECT_EQ(with("y[3,2]"), "accepted");
  EXPECT_THAT(with("y[4,2]"), HasSubstr("beyond its array"));
  EXPECT_THAT(with("y[0,2]"), HasSubstr("beyond its array"));
  EXPECT_THAT(with("y[1]"), HasSubstr("has 2 dimensions"));
  EXPECT_THAT(with("y[1,x]"), HasSubstr("names no element"));
  EXPECT_THAT(with("y"), HasSubstr("has 2 dimensions"));
}

TEST(DamagedFmus, PlansAreBytesAndBack) {
  fmu::Plan plan;
  plan.version = 3;
  plan.binary = "/tmp/a.so";
  plan.inputs = {{"y", 7, fmu::Type::int16, 2, {1, 2, 3}}};
  plan.outputs = {{"u", 8, fmu::Type::float64, 0, {0}}};
  plan.settings = {{"name", 9, fmu::Type::string, {"text", ""}}};
  const std::string bytes = fmu::to_bytes(plan);
  fmu::Plan back;
  ASSERT_TRUE(fmu::from_bytes(bytes, back));
  EXPECT_EQ(fmu::to_bytes(back), bytes);
  EXPECT_EQ(back.inputs.at(0).start.at(2), 3);
  for (std::size_t k = 0; k < bytes.size(); ++k) EXPECT_FALSE(fmu::from_bytes(bytes.substr(0, k), back));
}

}  // namespace
}  // namespace mimbre::test::damaged_fmus
