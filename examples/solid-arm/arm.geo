// A-arm of the Iltis' front left suspension as a solid part: two square bars with eyes at their ends.
// Millimetres; x along the pivot axis (forward), y from its centre to the ball joint, z normal to the arm.
//   gmsh -3 -order 2 -format msh22 arm.geo -o arm.msh
SetFactory("OpenCASCADE");

If (!Exists(size)) size = 35; EndIf   // of the elements; finer: -setnumber size 10
half = 108;                       // from the centre to each pivot
reach = 321.4603;                 // from the pivot axis to the ball joint
seat_x = 75;                      // lower end of the shock absorber
seat_y = 248.6166;
seat_z = -4.6668;
side = 29.8;                      // of the bars

length = Sqrt(half^2 + reach^2);
Box(1) = {0, -side / 2, -side / 2, length, side, side};
Rotate {{0, 0, 1}, {0, 0, 0}, Atan2(reach, half)} { Volume{1}; }
Translate {-half, 0, 0} { Volume{1}; }
Box(2) = {0, -side / 2, -side / 2, length, side, side};
Rotate {{0, 0, 1}, {0, 0, 0}, Atan2(reach, -half)} { Volume{2}; }
Translate {half, 0, 0} { Volume{2}; }
Cylinder(3) = {-half - 26, 0, 0, 52, 0, 0, 24};                 // eyes of the pivots
Cylinder(4) = {half - 26, 0, 0, 52, 0, 0, 24};
Cylinder(5) = {0, reach, -20, 0, 0, 40, 30};                    // eye of the ball joint
Cylinder(6) = {seat_x - 15, seat_y, seat_z, 30, 0, 0, 18};      // eye of the shock absorber
Box(7) = {20, seat_y - 10, seat_z - 6, seat_x - 28, 20, 18};         // carries it
BooleanUnion(10) = { Volume{1}; Delete; }{ Volume{2:7}; Delete; };
Cylinder(11) = {-half - 26, 0, 0, 52, 0, 0, 12};                // bores
Cylinder(12) = {half - 26, 0, 0, 52, 0, 0, 12};
Cylinder(13) = {0, reach, -20, 0, 0, 40, 16};
Cylinder(14) = {seat_x - 15, seat_y, seat_z, 30, 0, 0, 8};
BooleanDifference(20) = { Volume{10}; Delete; }{ Volume{11:14}; Delete; };

// Where joints and the shock absorber take hold: the faces within a box around each bore.
e = 0.5;
front() = Surface In BoundingBox{half - 26 - e, -12 - e, -12 - e, half + 26 + e, 12 + e, 12 + e};
rear() = Surface In BoundingBox{-half - 26 - e, -12 - e, -12 - e, -half + 26 + e, 12 + e, 12 + e};
ball() = Surface In BoundingBox{-16 - e, reach - 16 - e, -20 - e, 16 + e, reach + 16 + e, 20 + e};
seat() = Surface In BoundingBox{seat_x - 15 - e, seat_y - 8 - e, seat_z - 8 - e,
                                seat_x + 15 + e, seat_y + 8 + e, seat_z + 8 + e};
Printf("%g %g %g %g", #front(), #rear(), #ball(), #seat());
Physical Volume("arm") = {20};
Physical Surface("front") = {front()};
Physical Surface("rear") = {rear()};
Physical Surface("ball") = {ball()};
Physical Surface("seat") = {seat()};

Mesh.MeshSizeMax = size;
Mesh.MeshSizeFromCurvature = 6;   // elements around a bore
Mesh.HighOrderOptimize = 1;       // no element folds where its edges become round
