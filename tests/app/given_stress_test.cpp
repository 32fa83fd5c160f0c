#include <fmt/format.h>
#include <gmock/gmock.h>

#include "app/program.h"
#include "fe_files/npz_writer.h"
#include "mimbre/fe_import.h"

/// mimbre reduce --stress, and where mimbre convert leaves stress.
namespace mimbre::app_test::given_stress_test {
namespace {

using Eigen::MatrixXd;
using testing::HasSubstr;

const std::string data = MIMBRE_SOURCE_DIR "/tests/data/";

class GivenStress : public ProgramTest {
 protected:
  const std::vector<std::string> matrices{"reduce",       data + "scipy/stiffness-csr.npz",
                                          "--mass",       data + "scipy/mass-csc.npz",
                                          "--nodes",      data + "scipy/nodes.csv",
                                          "--dofs",       data + "scipy/dofs.csv",
                                          "--interface",  "root=box(0,0,0, 0,1,1)",
                                          "--modes",      "4",
                                          "--free-modes", "0",
                                          "-o",           "body.h5",
                                          "--json"};

  Outcome reduce(const std::vector<std::string>& more) const {
    std::vector<std::string> arguments = matrices;
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  }
  ReducedBody body(const std::string& name = "body.h5") const {
    return load_reduced_body((folder / name).string());
  }
};

TEST_F(GivenStress, BecomesThatOfTheBody) {
  const fe::SolidMesh mesh = fe::read_inp(data + "calculix/beam.inp").mesh;
  const fe::ImportedMatrices read =
      fe::read_sparse_matrices(data + "scipy/stiffness-csr.npz", data + "scipy/mass-csc.npz",
                               data + "scipy/nodes.csv", data + "scipy/dofs.csv");
  const auto write = [&](double factor) {
    const std::vector<fe::SurfacePoint> points{{4, Eigen::Vector3d::Zero()}, {8, Eigen::Vector3d::Zero()}};
    const MatrixXd stress =
        factor * fe::recover(mesh, points, read.file_dofs, MatrixXd::Identity(36, 36)).stress;
    write_file(folder / "stress.npz", fe::npz_of(stress.sparseView()));
  };
  write(1);
  write_file(folder / "nodes.csv", fmt::format("{}\n{}\n", mesh.labels[4], mesh.labels[8]));
  EXPECT_EQ(reduce({}).code, 0);
  EXPECT_EQ(body().stress.size(), 0);
  const std::vector<std::string> given{"--stress", "stress.npz", "--stress-nodes", "nodes.csv"};
  const Outcome outcome = reduce(given);
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_TRUE(outcome.json().at("passed"));
  const ReducedBody once = body();
  EXPECT_EQ(once.node_labels, (std::vector<std::int64_t>{mesh.labels[4], mesh.labels[8]}));
  ASSERT_EQ(once.stress.rows(), 12);
  EXPECT_GT(once.stress.norm(), 0);
  // Other bytes in the file of that name: no body from the cache.
  write(2);
  const Outcome again = reduce(given);
  ASSERT_EQ(again.code, 0) << again.err;
  EXPECT_FALSE(again.json().at("cached"));
  EXPECT_LT((body().stress - 2 * once.stress).norm(), 1e-9 * once.stress.norm());

  // Stress goes along into SID and back.
  ASSERT_EQ(run({"convert", "body.h5", "--to", "sid"}).code, 0);
  ASSERT_EQ(run({"convert", "body.sid", "--to", "h5", "-o", "back.h5"}).code, 0);
  EXPECT_EQ(body("back.h5").stress, body().stress);
  EXPECT_EQ(body("back.h5").node_labels, once.node_labels);
  ASSERT_EQ(run({"convert", "body.h5", "--to", "h5", "--no-stress", "-o", "small.h5"}).code, 0);
  EXPECT_EQ(body("small.h5").stress.size(), 0);
}

TEST_F(GivenStress, SaysWhatIsWrong) {
  write_file(folder / "stress.npz", fe::npz_of(MatrixXd::Ones(6, 36).sparseView()));
  const Outcome rows = reduce({"--stress", "stress.npz"});
  EXPECT_EQ(rows.code, 1);
  EXPECT_THAT(rows.err, HasSubstr("has 6 rows where the model's 12 nodes need 72"));
  write_file(folder / "nodes.csv", "1\n");
  const Outcome table = reduce({"--stress-nodes", "nodes.csv"});
  EXPECT_EQ(table.code, 2);
  EXPECT_THAT(table.err, HasSubstr("--stress FILE"));
  // A matrix by which a body that moves as a whole is stressed.
  const Outcome rigid = reduce({"--stress", "stress.npz", "--stress-nodes", "nodes.csv"});
  EXPECT_EQ(rigid.code, 4) << rigid.err;
  EXPECT_FALSE(rigid.json().at("passed"));
}

}  // namespace
}  // namespace mimbre::app_test::given_stress_test
