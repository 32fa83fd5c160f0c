#include "mimbre/input_table.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>

#include "mimbre/unknown_name.h"

namespace mimbre::input_table_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class InputTable : public ::testing::Test {
 protected:
  InputTable() {
    const auto add = [&](const char* name, const char* unit) {
      spec::Input input;
      input.name = name;
      input.unit = unit;
      inputs.push_back(input);
    };
    add("u", "N m");
    add("w", "");
    add("share", "1");
    add("time", "s");
  }
  ~InputTable() override { std::filesystem::remove(path); }

  std::vector<RecordedInput> read(const std::string& text, const std::string& name = "u") {
    std::ofstream(path, std::ios::binary) << text;
    return read_input_table(path, inputs, name);
  }
  std::string refusal(const std::string& text, const std::string& name = "u") {
    try {
      read(text, name);
    } catch (const InputError& error) {
      const Diagnostic& first = error.diagnostics().front();
      EXPECT_EQ(first.mark.file, path);
      return std::to_string(first.mark.line) + ": " + first.message;
    }
    return "none";
  }
  /// Of the one column: times and values behind each other.
  std::vector<double> numbers(const std::string& text, const std::string& name = "u") {
    const auto all = read(text, name);
    if (all.size() != 1) return {};
    std::vector<double> flat = all[0].times;
    flat.insert(flat.end(), all[0].values.begin(), all[0].values.end());
    return flat;
  }

  std::vector<spec::Input> inputs;
  const std::string path = testing::TempDir() + "input_table_" +
                           ::testing::UnitTest::GetInstance()->current_test_info()->name() + ".csv";
};

TEST_F(InputTable, IsReadByItsHeader) {
  const std::vector<double> wanted{0, 0.5, 3, -2};
  for (const char* text :
       {"t,value\n0,3\n0.5,-2\n", "value,t\n3,0\n-2,0.5\n", "Time,u\n0,3\n0.5,-2",
        "u [N m],t [s]\n3,0\n-2,0.5\n", "t [s],value [Nm]\n0,3\n0.5,-2\n", "t,w,u\n0,9,3\n0.5,x,-2\n",
        "t,u\ns,N m\n0,3\n0.5,-2\n", "t,u\n[s],[N m]\n0,3\n0.5,-2\n",
        "\"t [s]\",\"u [N m]\"\n\"0\",\"3\"\n0.5,-2\n", "\xEF\xBB\xBFt,u\r\n0,3\r\n0.5,-2\r\n",
        "t;u\n0;3\n0,5;-2\n", "t\tu\n0\t3\n0,5\t-2,0\n", "t;u\n0;3\n.5;-2\n",
        "# recorded on Monday\n\n t , u \n 0 , +3 \n# half\n\n 5e-1 , -2 \n", "u,t,share\n3,0,\n-2,0.5,\n"})
    EXPECT_EQ(numbers(text), wanted) << text;
  const auto found = read("t,u\n0,1\n");
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].input, 0);
}

TEST_F(InputTable, WithoutAHeaderHasTimeAndValue) {
  EXPECT_THAT(numbers("0,3\n0.5,-2\n"), ElementsAre(0, 0.5, 3, -2));
  EXPECT_THAT(numbers("\xEF\xBB\xBF-1;0,25\r\n0,5;1e-3\r\n"), ElementsAre(-1, 0.5, 0.25, 1e-3));
  EXPECT_THAT(refusal("0,3,1\n"), HasSubstr("1: has 3 columns, and no header that names them"));
  EXPECT_THAT(refusal("0\n"), HasSubstr("1: has 1 columns"));
  EXPECT_THAT(refusal("0,3\n", ""), HasSubstr("1: has no header with the names of inputs"));
}

TEST_F(InputTable, HasSeveralInputs) {
  const auto all = read("w,t [s],u [N m]\r\n1,0,\r\n,0.5,2\r\n3,1,4\r\n", "");
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0].input, 1);
  EXPECT_THAT(all[0].times, ElementsAre(0, 1));
  EXPECT_THAT(all[0].values, ElementsAre(1, 3));
  EXPECT_EQ(all[1].input, 0);
  EXPECT_THAT(all[1].times, ElementsAre(0.5, 1));
  EXPECT_THAT(all[1].values, ElementsAre(2, 4));
  // An input may be called as times are.
  const auto timed = read("t,time\n0,7\n", "");
  ASSERT_EQ(timed.size(), 1u);
  EXPECT_EQ(timed[0].input, 3);
  EXPECT_THAT(numbers("time,u\n0,7\n"), ElementsAre(0, 7));
  EXPECT_THAT(numbers("t,u\n0,1e-400\n1,-1E-999\n2,4e-320\n"), ElementsAre(0, 1, 2, 0, 0, 4e-320));
}

TEST_F(InputTable, RefusesWhatIsNoNumberWithItsLine) {
  EXPECT_THAT(refusal("t,u\n0,nan\n0.5,2\n"), HasSubstr("2: the value of 'u': 'nan' is not a finite number"));
  EXPECT_THAT(refusal("0,nan\n0.5,2\n"), HasSubstr("1: the value of 'u': 'nan' is not a finite number"));
  EXPECT_THAT(refusal("t,u\n0,1\ninf,2\n"), HasSubstr("3: the time: 'inf' is not a finite number"));
  EXPECT_THAT(refusal("t,u\n0,1e999\n"), HasSubstr("not a finite number"));
  EXPECT_THAT(refusal("t,u\n0,1\n0.5,2 N\n"), HasSubstr("3: the value of 'u': '2 N' is not a number"));
  EXPECT_THAT(refusal("t,u\n0,1\nend,2\n"), HasSubstr("3: the time: 'end' is not a number"));
  EXPECT_THAT(refusal("t,u\n0,\n"), HasSubstr("2: the value of 'u': '' is not a number"));
  EXPECT_THAT(refusal("t,u\n0,0x10\n"), HasSubstr("not a number"));
  EXPECT_THAT(refusal("t,u,w\n0,1,1\n1,,\n", ""), HasSubstr("3: has a time and no value"));
  EXPECT_THAT(refusal("t,u\nabc,3\n0,1\n"), HasSubstr("2: the time: 'abc' is not a number"));
}

TEST_F(InputTable, RefusesWrongColumns) {
  EXPECT_THAT(refusal("t,v\n0,1\n"), HasSubstr("1: has no column 'u' or `value`; its columns are 't', 'v'"));
  EXPECT_THAT(refusal("x,u\n0,1\n"), HasSubstr("1: has no column `t` or `time`; its columns are 'x', 'u'"));
  EXPECT_THAT(refusal("t,u,u\n0,1,1\n"), HasSubstr("1: has more than one column 'u'"));
  EXPECT_THAT(refusal("t,time,u\n0,0,1\n", "w"), HasSubstr("has no column 'w'"));
  EXPECT_THAT(refusal("t,Time,u\n0,0,1\n"), HasSubstr("1: has more than one column of times"));
  EXPECT_THAT(refusal("t,u,w,u\n0,1,1,1\n", ""), HasSubstr("1: has more than one column 'u'"));
  EXPECT_THAT(
      refusal("t,u,shar\n0,1,1\n", ""),
      HasSubstr(
          "1: column 'shar' is not an input or tunable parameter of the model (did you mean 'share'?)"));
  EXPECT_THAT(refusal("t\n0\n", ""), HasSubstr("1: has no column of an input"));
  EXPECT_THAT(refusal("t,u,\n0,1,\n"), HasSubstr("1: column 3 has no name"));
  EXPECT_THROW(read("t,u\n0,1\n", "nobody"), UnknownName);
}

TEST_F(InputTable, RefusesUnitsThatAreNotTheInputs) {
  EXPECT_THAT(refusal("t,u [kN m]\n0,1\n"),
              HasSubstr("1: the column of 'u' is in 'kN m', and the input is in 'N m'"));
  EXPECT_THAT(refusal("t,u [rad]\n0,1\n"), HasSubstr("is in 'rad'"));
  EXPECT_THAT(refusal("t [ms],u\n0,1\n"), HasSubstr("1: the times are in 'ms'; they are needed in s"));
  EXPECT_THAT(refusal("t,u\nms,N m\n0,1\n"), HasSubstr("2: the times are in 'ms'"));
  EXPECT_THAT(refusal("t,u\ns,deg\n0,1\n"), HasSubstr("2: the column of 'u' is in 'deg'"));
  EXPECT_THAT(refusal("t,u [N\n0,1\n"), HasSubstr("1: 'u [N': a column's head is its name and its unit"));
  EXPECT_THAT(refusal("t,share [m]\n0,1\n", "share"), HasSubstr("and the input is in '1'"));
  EXPECT_EQ(numbers("t,share [-]\n0,1\n", "share").size(), 2u);
  // An input without a unit is in SI units.
  EXPECT_EQ(numbers("t,w [m/s]\n0,1\n", "w").size(), 2u);
  EXPECT_THAT(refusal("t,w [deg]\n0,1\n", "w"), HasSubstr("its values are in SI units"));
  // Of a column that is not asked for no unit counts.
  EXPECT_EQ(numbers("t,w [deg],u\n0,1,1\n").size(), 2u);
}

TEST_F(InputTable, RefusesTimesThatDoNotIncrease) {
  EXPECT_THAT(refusal("t,u\n0,1\n0,2\n"), HasSubstr("3: the times do not increase: 0 comes after 0"));
  EXPECT_THAT(refusal("t,u\n1,1\n\n0.5,2\n"), HasSubstr("4: the times do not increase: 0.5 comes after 1"));
}

TEST_F(InputTable, RefusesRaggedLinesAndMixedMarks) {
  EXPECT_THAT(refusal("t,u\n0,1\n0.5\n"), HasSubstr("3: has 1 cell where the lines before have 2"));
  EXPECT_THAT(refusal("t,u\n0,0,1,5\n"),
              HasSubstr("2: has 4 cells where the lines before have 2 (numbers with "
                        "decimal commas need semicolons between them)"));
  EXPECT_THAT(refusal("t,u\n0;1\n"), HasSubstr("2: has 1 cell"));
  EXPECT_THAT(refusal("t;u\n0,5;1\n1.5;2\n"),
              HasSubstr("3: '1.5': the table has numbers with a decimal comma"));
  EXPECT_THAT(refusal("t;u\n0;1.234,5\n"), HasSubstr("2: '1.234,5'"));
  EXPECT_THAT(refusal("t,u\n\"0,1\n"), HasSubstr("2: has a quote that does not end with its cell"));
  EXPECT_THAT(refusal("t,u\n\"0\"1,1\n"), HasSubstr("2: has a quote"));
}

TEST_F(InputTable, RefusesFilesThatAreNoTables) {
  EXPECT_THAT(refusal(""), HasSubstr("0: has no line with a time and a value"));
  EXPECT_THAT(refusal("# nothing\n\n"), HasSubstr("has no line"));
  EXPECT_THAT(refusal("t,u\n"), HasSubstr("has no line"));
  EXPECT_THAT(refusal("t,u\ns,N m\n"), HasSubstr("has no line"));
  EXPECT_THAT(refusal(std::string("\xFF\xFEt\0,\0u\0\n\0", 10)), HasSubstr("1: holds zero bytes"));
  EXPECT_THAT(refusal("t,u,w\n0,1,\n", ""), HasSubstr("has no line"));  // of w
  EXPECT_THROW(read_input_table(testing::TempDir(), inputs, "u"), InputError);
  EXPECT_THROW(read_input_table(path + ".missing", inputs, "u"), InputError);
}

/// Whatever a file holds, it is read or refused.
TEST_F(InputTable, TakesOrRefusesDamagedFiles) {
  const std::string good = "t [s];u [N m];w\n0;1,5;\"2\"\n0,5;2;3\n# x\n1;3;4\n";
  unsigned seed = 1;
  const auto random = [&] { return seed = seed * 1664525u + 1013904223u, seed >> 8; };
  int taken = 0;
  for (int k = 0; k < 3000; ++k) {
    std::string text = good;
    for (unsigned n = random() % 4 + 1; n > 0 && !text.empty(); --n) {
      const std::size_t at = random() % text.size();
      switch (random() % 4) {
        case 0:
          text.erase(at, random() % 5);
          break;
        case 1:
          text.insert(at, 1, ";,\"[]\n\t#.9e-nN\xFF"[random() % 16]);
          break;
        case 2:
          text[at] = static_cast<char>(random());
          break;
        default:
          text.resize(at + 1);
      }
    }
    try {
      for (const RecordedInput& input : read(text, k % 2 ? "u" : "")) {
        ASSERT_FALSE(input.times.empty());
        ASSERT_EQ(input.times.size(), input.values.size());
        for (std::size_t i = 0; i < input.times.size(); ++i) {
          ASSERT_TRUE(std::isfinite(input.times[i]) && std::isfinite(input.values[i]));
          ASSERT_TRUE(i == 0 || input.times[i - 1] < input.times[i]);
        }
      }
      ++taken;
    } catch (const InputError&) {
    }
  }
  EXPECT_GT(taken, 50);
}

}  // namespace
}  // namespace mimbre::input_table_test
