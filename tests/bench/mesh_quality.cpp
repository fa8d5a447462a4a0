// SPDX-License-Identifier: GPL-3.0-or-later

// Measures MESH, a new mesh of a surface, and a mesh with about as many vertices that CGAL's isotropic remeshing makes
// of SURFACE. Usage: ccdt_mesh_quality SURFACE MESH CREASE. SURFACE and MESH are files of a format that CGAL reads,
// such as OBJ. Edges whose faces have normals more than CREASE degrees apart are creases, which the remeshing
// preserves.
#include <CGAL/Polygon_mesh_processing/IO/polygon_mesh_io.h>
#include <CGAL/Polygon_mesh_processing/bbox.h>
#include <CGAL/Polygon_mesh_processing/detect_features.h>
#include <CGAL/Polygon_mesh_processing/distance.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Polygon_mesh_processing/remesh.h>
#include <CGAL/Polygon_mesh_processing/triangulate_faces.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <numbers>

namespace ccdt::bench {
namespace {

namespace pmp = CGAL::Polygon_mesh_processing;
namespace parameters = CGAL::parameters;

using Kernel = CGAL::Simple_cartesian<double>;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;

bool read(const char* path, Mesh& mesh) {
    if (!pmp::IO::read_polygon_mesh(path, mesh)) {
        std::fprintf(stderr, "%s cannot be read as a surface\n", path);
        return false;
    }
    pmp::triangulate_faces(mesh);
    return true;
}

/// Replaces the triangles of a mesh, so that it has approximately `count` vertices.
void remesh(Mesh& mesh, std::size_t count, double crease) {
    const Mesh original = mesh;
    // The edge of equilateral triangles, of which there are twice as many as vertices.
    double edge = std::sqrt(2 * pmp::area(mesh) / (std::sqrt(3.0) * static_cast<double>(count)));
    constexpr int kAttempts = 4;
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
        mesh = original;
        const auto creases = mesh.add_property_map<Mesh::Edge_index, bool>("e:crease", false).first;
        pmp::detect_sharp_edges(mesh, crease, creases);
        pmp::isotropic_remeshing(faces(mesh), edge, mesh,
                                 parameters::number_of_iterations(10).edge_is_constrained_map(creases));
        mesh.collect_garbage();
        edge *= std::sqrt(static_cast<double>(mesh.number_of_vertices()) / static_cast<double>(count));
    }
}

/// Prints the quality of a mesh as a JSON object. The Hausdorff distance is relative to the diagonal of the bounding
/// box of the surface, and estimated from samples: 20 per triangle of the mesh.
void report(const char* name, const Mesh& surface, const Mesh& mesh, double seconds) {
    double sum = 0, squares = 0;
    std::size_t triangles = 0, good = 0;
    for (const auto face : mesh.faces()) {
        const double area = pmp::face_area(face, mesh);
        sum += area;
        squares += area * area;
        ++triangles;
        auto edge = mesh.halfedge(face);
        for (int corner = 0; corner < 3; ++corner, edge = mesh.next(edge)) {
            const auto& at = mesh.point(mesh.target(edge));
            const auto u = mesh.point(mesh.source(edge)) - at, v = mesh.point(mesh.target(mesh.next(edge))) - at;
            const double angle = std::atan2(std::sqrt(CGAL::cross_product(u, v).squared_length()), u * v);
            good += angle >= std::numbers::pi / 6 && angle <= 2 * std::numbers::pi / 3;
        }
    }
    const auto count = static_cast<double>(triangles);
    const double mean = sum / count;
    const auto box = pmp::bbox(surface);
    const double diagonal = std::hypot(box.x_span(), std::hypot(box.y_span(), box.z_span()));
    const double distance = pmp::approximate_symmetric_Hausdorff_distance<CGAL::Sequential_tag>(
        mesh, surface, parameters::number_of_points_per_area_unit(20 * count / sum),
        parameters::number_of_points_per_area_unit(20 * count / sum));
    std::printf(
        "{\"name\":\"%s\",\"vertices\":%zu,\"area_variation\":%.4f,\"good_angles\":%.5f,\"hausdorff\":%.3e,"
        "\"seconds\":%.3f}\n",
        name, static_cast<std::size_t>(mesh.number_of_vertices()),
        std::sqrt(std::max(0.0, squares / count / mean / mean - 1)), static_cast<double>(good) / (3 * count),
        distance / diagonal, seconds);
}

int run(const char* surface_path, const char* mesh_path, double crease) {
    Mesh surface, mesh;
    if (!read(surface_path, surface) || !read(mesh_path, mesh)) return 1;
    report("given", surface, mesh, 0);
    Mesh other = surface;
    const auto begin = std::chrono::steady_clock::now();
    remesh(other, mesh.number_of_vertices(), crease);
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
    report("CGAL", surface, other, elapsed.count());
    return 0;
}

}  // namespace
}  // namespace ccdt::bench

int main(int argc, char** argv) {
    if (argc != 4) {
        std::fputs("usage: ccdt_mesh_quality SURFACE MESH CREASE\n", stderr);
        return 2;
    }
    try {
        return ccdt::bench::run(argv[1], argv[2], std::atof(argv[3]));
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
}
