// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/split.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "api/output/archive.h"
#include "api/output/pen_labels.h"

namespace ccdt::api {
namespace {

constexpr std::size_t kMaxFiles = 1'000;

/// Returns labels with an underscore for each character that may be special in names of files.
std::vector<std::string> file_names(std::span<const Ink> inks) {
    std::vector<std::string> names = pen_labels(inks);
    for (std::string& name : names) {
        for (char& c : name) {
            const bool is_letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
            if (!is_letter) c = '_';
        }
    }
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (std::ranges::count(names, names[i]) > 1) names[i] += std::to_string(i + 1);
    }
    return names;
}

/// Dots of one ink that a file contains.
struct Part {
    Distribution dots;
    std::vector<std::uint32_t> features;
};

double length(std::span<const Point> line) {
    double sum = 0;
    for (std::size_t i = 1; i < line.size(); ++i) sum += std::sqrt(dot(line[i] - line[i - 1], line[i] - line[i - 1]));
    return sum;
}

/// Returns the options of a drawing whose lines end where their points end.
DrawingOptions opened(DrawingOptions drawing) {
    drawing.closed = false;
    return drawing;
}

/// Cuts the path of a pen into parts.
class Cutting {
public:
    /// @param layer  dots of one pen
    Cutting(const InkDots& layer, const PointSet& points, const Page& page, const DrawingOptions& drawing)
        : layer_(layer), points_(points), page_(page), drawing_(drawing) {}

    std::vector<Part> parts(const std::stop_token& path_stop, const std::stop_token& stop) {
        const Plot plot = plot_of(one(layer_), page_, drawing_, path_stop, stop);
        const Plotter& plotter = drawing_.plotter;
        const bool is_line = drawing_.style == DotStyle::Path;
        const double drawn = length(plot.pens.front().stroke);
        const double each = is_line ? 0 : drawn / plotter.speed + plotter.pauses(!(drawn > 0));
        std::size_t first = 0;
        for (const PenRun& run : plot.pens.front().runs) {
            for (std::size_t i = 0; i < run.path.size() && parts_.size() <= kMaxFiles; ++i) {
                const std::size_t dot = first + run.path[i], before = last_;
                const bool is_joined = is_line && i > 0;
                const double more =
                    each + distance(before, dot) / plotter.speed + (is_line && !is_joined ? plotter.pauses(false) : 0);
                // A part of a line has at least two dots.
                const bool is_short = is_joined && parts_.back().dots.points.size() < 2;
                if (!parts_.empty() && (is_short || seconds_ + more <= 60 * *drawing_.part_minutes)) {
                    add(dot);
                    seconds_ += more;
                    continue;
                }
                parts_.emplace_back();
                if (is_joined) add(before);
                add(dot);
                seconds_ = seconds_of_part();
            }
            first += run.points.size();
        }
        return std::move(parts_);
    }

private:
    PointSet one(const InkDots& layer) const { return {{&layer, 1}, points_.feature_ids, points_.properties, {}}; }

    void add(std::size_t dot) {
        Part& part = parts_.back();
        part.dots.points.push_back(layer_.dots.points[dot]);
        if (!layer_.dots.ranks.empty()) part.dots.ranks.push_back(layer_.dots.ranks[dot]);
        if (!layer_.features.empty()) part.features.push_back(layer_.features[dot]);
        last_ = dot;
    }

    double distance(std::size_t from, std::size_t to) const {
        const Point step = layer_.dots.points[to] - layer_.dots.points[from];
        return page_.unit() * std::sqrt(dot(step, step));
    }

    /// Returns the drawing time of the last part.
    double seconds_of_part() const {
        const InkDots layer{layer_.ink, parts_.back().dots, layer_.radius, nullptr, parts_.back().features};
        Page page = page_;
        page.along_path = false;
        return plot_of(one(layer), page, opened(drawing_), {}).size().seconds;
    }

    const InkDots& layer_;
    const PointSet& points_;
    const Page& page_;
    const DrawingOptions& drawing_;
    std::vector<Part> parts_;
    std::size_t last_ = 0;
    double seconds_ = 0;  ///< of the last part
};

/// Writes each part of a drawing to a file.
class Splitting {
public:
    Splitting(const PointFormat& format, const PointSet& points, const Palette& palette, const Page& page,
              const DrawingOptions& drawing, const std::stop_token& path_stop, const std::stop_token& stop)
        : format_(format),
          points_(points),
          palette_(palette),
          page_(page),
          drawing_(drawing),
          path_stop_(path_stop),
          stop_(stop) {}

    Result<void> write(Body& body) {
        if (const InkAreas* const areas = points_.layers.front().areas) {
            add_areas(*areas);
        } else {
            const auto names = file_names(points_.inks());
            for (std::size_t i = 0; i < points_.layers.size(); ++i) {
                drawing_.part_minutes ? add_parts(points_.layers[i], names[i])
                                      : add_file(names[i], points_.layers[i], page_, drawing_);
            }
        }
        if (files_.size() > kMaxFiles)
            return failure(ErrorCode::LimitExceeded, "split makes more than 1000 files", "split");
        if (size_) body.set_plot(*size_);
        return write_archive(std::move(files_), body);
    }

private:
    void add_areas(const InkAreas& areas) {
        const auto names = file_names(areas.inks);
        for (std::size_t i = 0; i < areas.inks.size(); ++i) {
            const InkAreas one{areas.inks.subspan(i, 1), {areas.rings[i]}};
            InkDots layer = points_.layers.front();
            layer.areas = &one;
            add_file(names[i], layer, page_, drawing_);
        }
    }

    void add_parts(const InkDots& layer, const std::string& name) {
        const auto parts = Cutting(layer, points_, page_, drawing_).parts(path_stop_, stop_);
        Page page = page_;
        page.along_path = false;
        const DrawingOptions open = opened(drawing_);
        for (std::size_t i = 0; i < parts.size() && files_.size() <= kMaxFiles; ++i) {
            const InkDots part{layer.ink, parts[i].dots, layer.radius, nullptr, parts[i].features};
            add_file(name + '-' + std::to_string(i + 1), part, page, open);
        }
    }

    void add_file(const std::string& name, const InkDots& layer, const Page& page, const DrawingOptions& drawing) {
        Body body;
        format_.vector()->write({{&layer, 1}, points_.feature_ids, points_.properties, points_.tone}, palette_, page,
                                drawing, body, path_stop_, stop_);
        const Answer answer = *body.finish({});
        files_.push_back({name + '.' + std::string(format_.file.extension), answer.body});
        if (!answer.plot) return;
        if (!size_) size_.emplace();
        size_->seconds += answer.plot->seconds;
        size_->path_mm += answer.plot->path_mm;
        size_->pen_mm = std::max(size_->pen_mm, answer.plot->pen_mm);
    }

    const PointFormat& format_;
    const PointSet& points_;
    const Palette& palette_;
    const Page& page_;
    const DrawingOptions& drawing_;
    const std::stop_token& path_stop_;
    const std::stop_token& stop_;
    std::vector<ArchivedFile> files_;
    std::optional<PlotSize> size_;  ///< of all files; none if pens draw none of them
};

}  // namespace

Result<void> write_drawing(const PointFormat& format, const PointSet& points, const Palette& palette, const Page& page,
                           const DrawingOptions& drawing, Body& body, const std::stop_token& path_stop,
                           const std::stop_token& stop) {
    if (drawing.is_split) return Splitting(format, points, palette, page, drawing, path_stop, stop).write(body);
    format.vector()->write(points, palette, page, drawing, body, path_stop, stop);
    return {};
}

}  // namespace ccdt::api
