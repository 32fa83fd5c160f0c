#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/common.h"
#include "app/json.h"
#include "app/reproduce/reproduce_tables.h"
#include "app/terminal/interrupts.h"
#include "app/terminal/table.h"
#include "app/terminal/terminal_line.h"
#include "mimbre/run.h"

/// mimbre reproduce: published tables beside ours.
namespace mimbre::app {
namespace {

struct ReproduceArguments {
  std::vector<std::string> tables;
  bool list = false, json = false, markdown = false;
};

struct Result {
  const PublishedTable* table;
  std::vector<ReproducedRow> rows;
};

std::vector<const PublishedTable*> selected(const std::vector<std::string>& names) {
  std::vector<const PublishedTable*> tables;
  std::vector<std::string> known;
  for (const PublishedTable& table : published_tables()) known.push_back(table.name);
  for (const std::string& name : names)
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw UsageError(fmt::format("--table: there is no table '{}'{}; --list prints them", name,
                                   did_you_mean(name, known)));
  for (const PublishedTable& table : published_tables())
    if (names.empty() || std::find(names.begin(), names.end(), table.name) != names.end())
      tables.push_back(&table);
  return tables;
}

std::string number(const std::optional<double>& value) {
  return value ? fmt::format("{:.4g}", *value) : std::string("–");
}

template <class Names>
void add_new(Names& names, const std::string& name) {
  if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
}

/// Series below each other, columns side by side; of each series published, ours, and ours over published.
Table crossed(const std::vector<ReproducedRow>& rows) {
  std::vector<std::string> all_series, columns;
  for (const ReproducedRow& row : rows) {
    add_new(all_series, row.series);
    add_new(columns, row.column);
  }
  std::vector<std::string> heading{"", ""};
  heading.insert(heading.end(), columns.begin(), columns.end());
  Table table(heading);
  for (const std::string& series : all_series) {
    std::vector<const ReproducedRow*> members;
    for (const ReproducedRow& row : rows)
      if (row.series == series) members.push_back(&row);
    const bool compared = std::any_of(members.begin(), members.end(),
                                      [](const ReproducedRow* row) { return row->published.has_value(); });
    std::string label = series;
    if (members.front()->unit != "1") label += ", " + members.front()->unit;
    const auto line = [&](const char* what, auto&& value) {
      std::vector<std::string> cells{label, what};
      label.clear();
      for (const std::string& column : columns) {
        const auto member = std::find_if(members.begin(), members.end(),
                                         [&](const ReproducedRow* row) { return row->column == column; });
        cells.push_back(member == members.end() ? "" : number(value(**member)));
      }
      table.add(cells);
    };
    if (compared) line("published", [](const ReproducedRow& row) { return row.published; });
    line("ours", [](const ReproducedRow& row) { return row.ours; });
    if (compared) line("ratio", [](const ReproducedRow& row) { return row.ratio(); });
  }
  return table;
}

/// The cases that a note is about: a series with the columns it holds for, or alone when it holds for all.
std::string cases_of(const std::vector<ReproducedRow>& rows, const std::string& note) {
  std::vector<std::string> all_series;
  for (const ReproducedRow& row : rows)
    if (row.note == note) add_new(all_series, row.series);
  std::string cases;
  for (const std::string& series : all_series) {
    std::string columns;
    bool all = true;
    for (const ReproducedRow& row : rows) {
      if (row.series != series) continue;
      if (row.note == note)
        columns += (columns.empty() ? "" : ", ") + row.column;
      else
        all = false;
    }
    cases += (cases.empty() ? "" : "; ") + series + (all ? "" : fmt::format(" ({})", columns));
  }
  return cases;
}

/// One line per note, with the cases it is about.
std::vector<std::string> notes(const std::vector<ReproducedRow>& rows) {
  std::vector<std::string> texts;
  for (const ReproducedRow& row : rows)
    if (!row.note.empty()) add_new(texts, row.note);
  for (std::string& note : texts) note = fmt::format("{}: {}", cases_of(rows, note), note);
  return texts;
}

std::string text(const Result& result, bool markdown) {
  const Table table = crossed(result.rows);
  std::string text =
      markdown ? fmt::format("### {}\n\n{}.\n\n{}", result.table->name, result.table->title, table.markdown())
               : fmt::format("{}: {}\n{}", result.table->name, result.table->title, table.text());
  const std::vector<std::string> lines = notes(result.rows);
  if (markdown && !lines.empty()) text += '\n';
  for (const std::string& line : lines) text += fmt::format("{} {}\n", markdown ? "-" : "  note:", line);
  return text;
}

Json to_json(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

Json to_json(const Result& result) {
  Json rows = Json::array();
  for (const ReproducedRow& row : result.rows) {
    Json json{{"table", result.table->name},         {"case", row.series + ", " + row.column},
              {"published", to_json(row.published)}, {"ours", to_json(row.ours)},
              {"ratio", to_json(row.ratio())},       {"unit", row.unit}};
    if (!row.note.empty()) json["note"] = row.note;
    rows.push_back(json);
  }
  return rows;
}

/// What is being measured, on a terminal.
class StatusLine {
 public:
  ~StatusLine() { clear(); }
  void show(const std::string& line) {
    if (terminal_) show_terminal_line(line);
  }
  void clear() { show(""); }

 private:
  bool terminal_ = has_terminal_line();
};

int list(bool as_json) {
  Json json = answer("reproduce");
  Json& names = json["tables"] = Json::array();
  Table table({"table", "what"});
  for (const PublishedTable& published : published_tables()) {
    names.push_back({{"name", published.name}, {"title", published.title}});
    table.add({published.name, published.title});
  }
  print_data(as_json ? to_text(json) + '\n' : table.text());
  return done;
}

int run_reproduce(const ReproduceArguments& arguments) {
  if (arguments.list) return list(arguments.json);
  const std::vector<const PublishedTable*> tables = selected(arguments.tables);
  catch_interrupts();
  Lab lab;
  Json json = answer("reproduce");
  json["rows"] = Json::array();
  bool first = true;
  for (const PublishedTable* table : tables) {
    StatusLine status;
    const Result result{table, table->make(lab, [&](const ReproducedRow& row) {
                          status.show(fmt::format("{}: {}, {}", table->name, row.series, row.column));
                        })};
    status.clear();
    if (arguments.json) {
      for (const Json& row : to_json(result)) json["rows"].push_back(row);
    } else {
      // Table by table: the whole takes minutes.
      print_data((first ? "" : "\n") + text(result, arguments.markdown));
    }
    first = false;
  }
  if (arguments.json) print_data(to_text(json) + '\n');
  return done;
}

}  // namespace

Command add_reproduce(CommandLine& program) {
  Parser parser = program.add_command("reproduce", "Published tables beside those of this machine");
  const auto arguments = std::make_shared<ReproduceArguments>();
  parser.add_option("--table", arguments->tables, "This table only; may be repeated")
      .type_name("NAME")
      .repeated();
  parser.add_flag("--list", arguments->list, "The tables' names");
  const Option json = parser.add_flag("--json", arguments->json, "The rows as JSON");
  parser.add_flag("--markdown", arguments->markdown, "The tables in Markdown").excludes(json);
  parser.footer(
      "Reruns what the tables in chapters 2 to 4 of U. Lugris' doctoral thesis (2008) are of, with models "
      "that are\n"
      "built into the program, and compares the bases of modes that its chapter 1 surveys. Times are CPU "
      "seconds\n"
      "of the steps, the least of at least three runs. Ratios are ours over published. All tables take some "
      "minutes;\n"
      "what they show is in docs/reproduction.md.\n"
      "Example:\n  mimbre reproduce --table coordinates-vehicle --table energy");
  return {parser, [arguments] { return run_reproduce(*arguments); }};
}

}  // namespace mimbre::app
