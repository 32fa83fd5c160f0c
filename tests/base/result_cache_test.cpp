#include "mimbre/result_cache.h"

#include <gmock/gmock.h>
#include <sys/stat.h>

#include "app/program.h"
#include "base/sha256.h"

/// The cache of results, and of `mimbre reduce`.
namespace mimbre::app_test::result_cache_test {
namespace {

using testing::HasSubstr;

std::string digest(const std::vector<std::string>& pieces) {
  Sha256 sha;
  for (const std::string& piece : pieces) sha.add(piece);
  return sha.hex();
}

// The examples of FIPS 180-4 and NIST's test vectors.
TEST(Sha256, DigestsAsTheStandardSays) {
  EXPECT_EQ(digest({}), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(digest({"abc"}), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(digest({"abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"}),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(digest({std::string(1000000, 'a')}),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(Sha256, DoesNotCareHowThePiecesAreCut) {
  std::string text;
  for (int k = 0; k < 300; ++k) text += static_cast<char>(k);
  for (const std::size_t cut : {0u, 1u, 55u, 56u, 63u, 64u, 65u, 128u, 299u})
    EXPECT_EQ(digest({text.substr(0, cut), text.substr(cut)}), digest({text})) << cut;
}

class ResultCacheTest : public ProgramTest {
 protected:
  /// Keeps a file of `size` bytes; its key.
  std::string keep(const ResultCache& cache, char content, std::size_t size) const {
    write_file(folder / "made", std::string(size, content));
    ContentKey key;
    key.add(std::string(1, content));
    const std::string name = key.hex();
    cache.store(name, about(content), (folder / "made").string());
    return name;
  }
  static std::string about(char content) { return std::string("about ") + content; }
  std::optional<std::string> fetch(const ResultCache& cache, const std::string& key) const {
    fs::remove(folder / "found");
    return cache.fetch(key, (folder / "found").string());
  }
  fs::path entry(const std::string& key) const { return folder / "cache" / (key + ".result"); }
};

TEST_F(ResultCacheTest, GivesBackWhatItKept) {
  const ResultCache cache(folder / "cache");
  const std::string a = keep(cache, 'a', 1000), b = keep(cache, 'b', 0);
  EXPECT_EQ(fetch(cache, a), "about a");
  EXPECT_EQ(read_file(folder / "found"), std::string(1000, 'a'));
  EXPECT_EQ(fetch(cache, b), "about b");
  EXPECT_EQ(fs::file_size(folder / "found"), 0u);
  EXPECT_FALSE(fetch(cache, std::string(64, '0')));
  EXPECT_FALSE(fs::exists(folder / "found"));
}

TEST_F(ResultCacheTest, DoesNotSeeDamagedEntries) {
  const ResultCache cache(folder / "cache");
  const std::string key = keep(cache, 'a', 1000), sound = read_file(entry(key));
  std::string flipped = sound;
  flipped[500] = 'b';
  for (const std::string& damaged :
       {std::string(), std::string("\n"), sound.substr(0, 64), sound.substr(0, 900), sound + "a", flipped}) {
    write_file(entry(key), damaged);
    EXPECT_FALSE(fetch(cache, key));
    EXPECT_FALSE(fs::exists(folder / "found"));
  }
  write_file(entry(key), sound);
  EXPECT_TRUE(fetch(cache, key));
}

TEST_F(ResultCacheTest, RemovesWhatWasNotUsedForLongest) {
  const ResultCache cache(folder / "cache", 5000);
  const std::string a = keep(cache, 'a', 1500), b = keep(cache, 'b', 1500), c = keep(cache, 'c', 1500);
  const auto now = fs::file_time_type::clock::now();
  write_file(folder / "cache/notes.txt", std::string(9000, 'x'));  // not the cache's own
  for (const auto& [key, age] : {std::pair{a, 3}, {b, 2}, {c, 1}})
    fs::last_write_time(entry(key), now - std::chrono::hours(age));
  EXPECT_TRUE(fetch(cache, a));
  const std::string d = keep(cache, 'd', 1500);
  EXPECT_FALSE(fs::exists(entry(b)));
  for (const std::string& key : {a, c, d}) EXPECT_TRUE(fetch(cache, key));
  EXPECT_TRUE(fs::exists(folder / "cache/notes.txt"));
  EXPECT_FALSE(fetch(cache, keep(cache, 'e', 6000)));  // would be all of it
}

TEST_F(ResultCacheTest, IsNoErrorWhereItCannotBe) {
  write_file(folder / "file", "");
  for (const fs::path& place : {fs::path(), folder / "file", folder / "file/below"}) {
    const ResultCache cache(place);
    EXPECT_FALSE(fetch(cache, keep(cache, 'a', 10)));
  }
}

/// mimbre reduce of a bar whose nodes are in an included file.
class CachedReduction : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    const std::string bar = read_file(MIMBRE_SOURCE_DIR "/tests/data/calculix/beam.inp");
    const std::size_t begin = bar.find("1,0,0,0"), end = bar.find("*ELEMENT");
    nodes = bar.substr(begin, end - begin);
    mesh = bar.substr(0, begin) + "*INCLUDE, INPUT=nodes.txt\n" + bar.substr(end);
    write_file(folder / "nodes.txt", "*NODE, NSET=Nall\n" + nodes);
    write_file(folder / "bar.inp", mesh);
    write_file(folder / "root.txt", "1 4 5 8\n");
  }

  /// Whether it came from the cache; `out.h5` is there afterwards.
  bool cached(const std::vector<std::string>& more = {}, const std::string& output = "out.h5") const {
    std::vector<std::string> arguments{
        "reduce", "bar.inp", "--interface", "root=nodes:root.txt", "--modes", "3", "-o", output, "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.code, 4) << outcome.err;  // done, but three modes are too few for the certificate
    return outcome.code == 4 && outcome.json().at("cached").boolean();
  }
  std::string body() const { return read_file(folder / "out.h5"); }

  std::string mesh, nodes;
};

TEST_F(CachedReduction, IsTheSameTheSecondTime) {
  const std::vector<std::string> arguments{"reduce",  "bar.inp", "--interface",      "root=nodes:root.txt",
                                           "--modes", "3",       "--effective-mass", "1",
                                           "-o",      "out.h5"};
  const auto after_first_line = [](const std::string& text) { return text.substr(text.find('\n')); };
  const Outcome first = run(arguments);
  ASSERT_EQ(first.code, 4) << first.err;  // done, but three modes are too few for the certificate
  const std::string made = body();
  fs::remove(folder / "out.h5");
  const Outcome second = run(arguments);
  ASSERT_EQ(second.code, 4) << second.err;
  EXPECT_EQ(body(), made);
  EXPECT_EQ(after_first_line(second.out), after_first_line(first.out));
  EXPECT_EQ(second.err, first.err);
  EXPECT_THAT(second.out, HasSubstr("from cache"));
  EXPECT_EQ(first.out.find("from cache"), std::string::npos);

  // The same files in another place; the name of the body is in it.
  fs::create_directory(folder / "moved");
  for (const char* file : {"bar.inp", "nodes.txt", "root.txt"})
    fs::rename(folder / file, folder / "moved" / file);
  std::vector<std::string> moved = arguments;
  moved[1] = "moved/bar.inp";
  moved[3] = "root=nodes:moved/root.txt";
  moved.back() = "moved/out.h5";
  EXPECT_THAT(run(moved).out, HasSubstr("from cache"));
  EXPECT_EQ(read_file(folder / "moved/out.h5"), made);
}

TEST_F(CachedReduction, IsMadeAnewWhereSomethingChanged) {
  EXPECT_FALSE(cached());
  EXPECT_TRUE(cached());
  EXPECT_FALSE(cached({"--damping", "0.01"}));
  EXPECT_FALSE(cached({}, "other.h5"));
  EXPECT_FALSE(cached({"--no-cache"}));
  EXPECT_TRUE(cached());
  const std::string made = body();

  write_file(folder / "bar.inp", mesh + "** changed\n");
  EXPECT_FALSE(cached());
  write_file(folder / "bar.inp", mesh);
  EXPECT_TRUE(cached());

  std::string longer = nodes;
  for (std::size_t at = 0; (at = longer.find(",2,", at)) != std::string::npos;) longer[at + 1] = '3';
  write_file(folder / "nodes.txt", "*NODE, NSET=Nall\n" + longer);
  EXPECT_FALSE(cached());
  EXPECT_NE(body(), made);
  write_file(folder / "nodes.txt", "*NODE, NSET=Nall\n" + nodes);
  EXPECT_TRUE(cached());
  EXPECT_EQ(body(), made);

  write_file(folder / "root.txt", "1 4 5\n");
  EXPECT_FALSE(cached());
  write_file(folder / "root.txt", "1 4 5 8\n");
  for (const char* extension : {"sti", "mas", "dof"})  // matrices beside the mesh are taken for it
    fs::copy(fs::path(MIMBRE_SOURCE_DIR "/tests/data/calculix/beam.") += extension,
             folder / (std::string("bar.") + extension));
  EXPECT_FALSE(cached());
}

TEST_F(CachedReduction, IsNotThatOfAnotherSetWhereFilesHaveTheNamesOfSets) {
  std::string with_sets = mesh;
  with_sets.insert(mesh.find("*MATERIAL"), "*NSET, NSET=LEFT\n19,20,11\n*NSET, NSET=RIGHT\n19,20,12\n");
  write_file(folder / "bar.inp", with_sets);
  for (const char* name : {"LEFT", "RIGHT"}) write_file(folder / name, "");
  EXPECT_FALSE(cached({"--interface", "end=set:LEFT"}));
  EXPECT_FALSE(cached({"--interface", "end=set:RIGHT"}));
}

/// What comes through it may be endless, and is gone when it has been read once.
TEST_F(CachedReduction, NodesThroughAPipeAreRefused) {
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
  const Outcome outcome =
      run({"reduce", "bar.inp", "--interface", "root=nodes:pipe", "--modes", "3", "-o", "out.h5", "--json"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("pipe: error: is a pipe or a device; a plain file is needed"));
}

TEST_F(CachedReduction, GoesWhereALinkLeads) {
  EXPECT_FALSE(cached());
  const std::string made = body();
  fs::create_directory(folder / "far");
  fs::rename(folder / "out.h5", folder / "far/out.h5");
  write_file(folder / "far/out.h5", "");
  fs::create_symlink("far/out.h5", folder / "out.h5");
  EXPECT_TRUE(cached());
  EXPECT_TRUE(fs::is_symlink(folder / "out.h5"));
  EXPECT_EQ(read_file(folder / "far/out.h5"), made);
}

TEST_F(CachedReduction, IsMadeAnewWhereTheEntryIsDamaged) {
  EXPECT_FALSE(cached());
  const std::string made = body();
  const auto entry = fs::directory_iterator(folder / "cache")->path();
  write_file(entry, read_file(entry).substr(0, 2000));
  EXPECT_FALSE(cached());
  EXPECT_EQ(body(), made);
  EXPECT_TRUE(cached());
}

TEST_F(CachedReduction, SaysWhatIsWrongWithTheFilesItFollows) {
  fs::remove(folder / "nodes.txt");
  const Outcome outcome = run({"reduce", "bar.inp", "--interface", "root=nodes:root.txt", "-o", "out.h5"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("nodes.txt"));
}

}  // namespace
}  // namespace mimbre::app_test::result_cache_test
