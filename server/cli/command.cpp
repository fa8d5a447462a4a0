// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/cli/command.h"

#include <algorithm>
#include <array>
#include <utility>

#include "api/analyze/analyze.h"
#include "api/halftone/device_picture.h"
#include "api/input/negotiation.h"
#include "api/output/formats.h"
#include "api/sample/choice/choice_formats.h"
#include "api/sample/pixels/pixel_formats.h"
#include "api/sample/spatial/surface_formats.h"
#include "api/sample/spatial/volume_formats.h"
#include "api/text/text.h"
#include "server/cli/api_schema.h"

namespace ccdt::server {
namespace {

using Formats = std::vector<const api::FileFormat*>;

Formats joined(Formats first, const Formats& second) {
    first.insert(first.end(), second.begin(), second.end());
    return first;
}

constexpr auto kHalftoneSchemas = std::to_array<std::string_view>({"HalftoneOptions", "DeviceOptions"});
constexpr auto kSampleSchemas =
    std::to_array<std::string_view>({"SampleRequest", "PixelRequest", "SurfaceOptions", "VolumeOptions"});
constexpr auto kChooseSchemas = std::to_array<std::string_view>({"ChoiceOptions"});
constexpr auto kAnalyzeSchemas = std::to_array<std::string_view>({"AnalyzeRequest", "SurfaceAnalyzeRequest"});

constexpr auto kHalftoneExamples = std::to_array<std::string_view>({
    "ccdt halftone photo.jpg -o dots.png",
    "ccdt halftone photo.jpg -o dots.svg --sites 20000 --color cmyk",
    "ccdt halftone *.jpg -o 'out/{name}.svg'",
    "curl -s https://example.org/photo.jpg | ccdt halftone - -o - > dots.png",
    "ccdt halftone photo.jpg -o panel.bmp --device spectra6 --width 800 --height 480 --fit cover",
});
constexpr auto kSampleExamples = std::to_array<std::string_view>({
    "ccdt sample map.geojson --sites 5000 -o dots.csv",
    "ccdt sample districts.zip --sites people --per 500 --properties name -o dots.geojson",
    R"(ccdt sample --domain '{"type":"torus","width":1,"height":1}' --sites 1000 -o points.csv)",
    "ccdt sample --polygon @shape.json --density @weights.png --sites 1000 -o dots.svg",
    "ccdt sample bunny.obj --sites 4000 -o points.ply",
    "ccdt sample bunny.obj --sites 4000 --mesh -o remeshed.glb",
    "ccdt sample bunny.obj --domain solid --sites 4000 --mesh -o tetrahedra.vtu",
    "ccdt sample voxels.npy --domain box --sites 4000 -o points.ply",
});
constexpr auto kChooseExamples = std::to_array<std::string_view>({
    "ccdt choose occurrences.csv --sites 500 -o thinned.csv",
    "ccdt choose stations.geojson --sites 40 --coordinates lonlat --priority rank -o stations40.geojson",
    "ccdt choose scan.ply --sites 20k -o reduced.ply",
});
constexpr auto kAnalyzeExamples = std::to_array<std::string_view>({
    "ccdt analyze points.csv -o spectrum.svg",
    R"(ccdt analyze points.npy --domain '{"type":"rectangle","width":4,"height":3}')",
    R"(ccdt analyze space.ply --domain '{"type":"torus","width":1,"height":1,"depth":1}')",
    "ccdt analyze points.ply --mesh bunny.obj",
});

const std::array kCommands = {
    Command{
        "halftone", "turn pictures into dots, or into the pixels of a device", "PICTURE... [OPTION]...",
        "A PICTURE is a PNG, JPEG, WebP, TIFF, GIF, BMP, AVIF or HEIC file. Colour profiles and EXIF orientation are "
        "applied.",
        kHalftoneExamples, kHalftoneSchemas,
        [] { return joined(api::files_of(api::halftone_formats()), api::files_of(api::device_formats())); }},
    Command{"sample", "spread points evenly in areas, on surfaces and in space", "[FILE...] [OPTION]...",
            "A FILE is a map: a GeoJSON or TopoJSON document, a zip archive with a shapefile of polygons, or the JSON "
            "of a request to the service; or a mesh: an STL, OBJ, PLY, OFF, GLB, or glTF file with embedded buffers; "
            "or a density in space: an NPY file with an array (depth, height, width), or a TIFF with several pages. "
            "Without a FILE, an option gives the area: --domain, --polygon or --geometry.",
            kSampleExamples, kSampleSchemas,
            [] {
                return joined(joined(api::files_of(api::sample_formats()), api::files_of(api::pixel_formats())),
                              joined(api::files_of(api::surface_formats()), api::files_of(api::volume_formats())));
            }},
    Command{
        "choose", "choose an exact number of given points, evenly spread", "FILE... [OPTION]...",
        "A FILE has a record for each point: a CSV whose first line names the columns, among them x and y, or "
        "longitude and latitude; GeoJSON with a point for each Feature, also one Feature per line; an NPY file with "
        "an array of at least two columns; or a PLY. Chosen records of CSV, GeoJSON and PLY are written as they "
        "are; for NPY, their indices are.",
        kChooseExamples, kChooseSchemas, [] { return api::files_of(api::choice_formats()); }},
    Command{
        "analyze", "measure how evenly points are spread", "[POINTS...] [OPTION]...",
        "POINTS is a CSV file with the columns x and y, an NPY file with an array of at least two columns, a PLY, a "
        "JSON list of positions, GeoJSON, or a JSON answer of ccdt sample or ccdt halftone. The "
        "points are in space, with a third coordinate, z, if --domain has a depth or, without --domain, in a PLY and "
        "in a CSV with the column z; and on the surface of a mesh with --mesh. Without POINTS, --sets gives sets of "
        "points.",
        kAnalyzeExamples, kAnalyzeSchemas, [] { return api::files_of(api::analyze_formats()); }},
};

constexpr auto kOtherCommands = std::to_array<OtherCommand>({
    {"serve", "serve [OPTION]...", "start ccdt-server, the HTTP service, with its options"},
    {"completion", "completion bash|zsh|fish", "print the completion of commands for a shell"},
    {"manual", "manual [COMMAND]", "print a manual page, for man(1)"},
    {"help", "help [COMMAND]", "print help"},
});

/// Members of the API that are no options of the program: without a service, on_deadline has no effect, and the input
/// file contains the points.
constexpr auto kOmitted = std::to_array<std::string_view>({"on_deadline", "points", "candidates"});

const std::array kProgramOptions = {
    Option{.name = "output",
           .value = "FILE",
           .description =
               "File of the answer, or - for standard output. With several inputs, {name} in FILE stands for the name "
               "of the input's file without its suffix. {ink} splits a drawing into files, and stands for their names "
               "without suffix. A folder stands for {name} in it, with --split for {name}-{ink}. The suffix of FILE "
               "chooses the format, unless --format is given. An existing file is replaced once the answer is "
               "complete. Without this option, the answer goes to standard output, but only text goes to a terminal.",
           .takes_text = true,
           .letter = 'o'},
    Option{.name = "quiet",
           .description = "Prints neither progress nor warnings. Errors are still printed.",
           .letter = 'q'},
    Option{.name = "json",
           .description = "Prints each message as a line of JSON on standard error. The member type is progress, "
                          "warning, result or error."},
    Option{.name = "help", .description = "Prints help.", .letter = 'h'},
    Option{.name = "threads",
           .value = "N",
           .description = "Maximum number of threads. The answer does not depend on it.",
           .allowed = "from 1 to 1024",
           .default_value = "one per core",
           .takes_number = true},
    Option{.name = "memory",
           .value = "BYTES",
           .description = "Refuses a request that may need more memory. Accepts KiB, MiB and GiB.",
           .default_value = "three quarters of the memory of the machine or container",
           .takes_text = true},
    Option{.name = "max-sites",
           .value = "N",
           .description = "Maximum number of dots or points of an answer.",
           .allowed = "from 1 to 100000000",
           .default_value = "100000000",
           .takes_number = true},
    Option{.name = "max-pixels",
           .value = "N",
           .description = "Maximum number of pixels of a picture that is read or drawn.",
           .allowed = "from 1 to 1000000000",
           .default_value = "1000000000",
           .takes_number = true},
    Option{.name = "max-faces",
           .value = "N",
           .description = "Maximum number of faces of a mesh, in triangles.",
           .allowed = "from 1 to 100000000",
           .default_value = "100000000",
           .takes_number = true},
};

struct GroupRow {
    std::string_view title;
    /// Names of options, with blanks before and after each. `name=VALUE` stands for an option with such a value, if
    /// another command has a flag of the same name.
    std::string_view names;
};

constexpr auto kGroups = std::to_array<GroupRow>({
    {"Area", " domain mesh=FILE depth polygon holes geometry object coordinates invalid buffer avoid exclude "},
    {"Dots", " sites minutes per classes properties density fixed sets dot dots tone detail levels alpha invert "},
    {"Records of points", " x y z priority keep spacing "},
    {"Colour", " color palette foreground background "},
    {"Placement", " method quality iterations passes tolerance crease order mesh seed "},
    {"Analysis", " max-frequency spectrum modes "},
    {"Format and size",
     " format multipoint width height scale fit gravity antialias width-mm dpi jpeg-quality split outlines "
     "legend minzoom maxzoom dots-per-tile "},
    {"Plotters", " paper margin marks style closed pen speed dwell machine dwell-unit pen-down pen-up "},
    {"Devices", " device rotate spot bit-order invert-bits "},
    {"Pixels of a raster", " include calibration "},
    {"Files and messages", " output quiet json help "},
    {"Limits", " threads memory max-sites max-pixels max-faces "},
});

constexpr auto kExitStatuses = std::to_array<ExitStatus>({
    {"0", "All answers are complete."},
    {"1", "A request failed: it has no usable result, or it exceeds a limit."},
    {"2", "The command line is wrong: an unknown option, a value out of range, or two inputs with the same output."},
    {"3", "An input cannot be read, or its format is not supported."},
    {"4", "An output cannot be written."},
    {"130, 143", "SIGINT or SIGTERM ended the program, as a shell reports it."},
});

/// Replaces what the API says about the option `format` by what is true for the program.
void describe_format(Option& option) {
    constexpr std::string_view kOfTheApi = "Takes precedence over the header Accept.";
    if (option.description.starts_with(kOfTheApi)) option.description.erase(0, kOfTheApi.size());
    option.description.insert(0, "Format of the answer. By default, the suffix of --output chooses it.");
}

}  // namespace

std::span<const Command> commands() {
    return kCommands;
}

const Command* find_command(std::string_view name) {
    const auto found = std::ranges::find(kCommands, name, &Command::name);
    return found == kCommands.end() ? nullptr : &*found;
}

std::span<const OtherCommand> other_commands() {
    return kOtherCommands;
}

std::vector<Option> options_of(const Command& command) {
    std::vector<Option> options = read_options(command.schemas);
    std::erase_if(options,
                  [](const Option& option) { return std::ranges::find(kOmitted, option.member) != kOmitted.end(); });
    const auto format = std::ranges::find(options, "format", &Option::name);
    if (format != options.end()) describe_format(*format);
    options.insert(options.end(), kProgramOptions.begin(), kProgramOptions.end());
    return options;
}

std::vector<OptionGroup> group_options(std::span<const Option> options) {
    std::vector<OptionGroup> groups;
    std::vector<const Option*> others;
    for (const Option& option : options) others.push_back(&option);
    for (const auto& [title, names] : kGroups) {
        OptionGroup group{title, {}};
        const auto is_member = [&names = names](const Option* option) {
            return names.find(' ' + option->name + ' ') != std::string_view::npos ||
                   names.find(' ' + option->name + '=' + option->value + ' ') != std::string_view::npos;
        };
        std::ranges::copy_if(others, std::back_inserter(group.options), is_member);
        std::erase_if(others, is_member);
        if (!group.options.empty()) groups.push_back(std::move(group));
    }
    if (!others.empty()) groups.push_back({"Other options", std::move(others)});
    return groups;
}

std::string_view first_sentence(std::string_view text) {
    const auto end = text.find(". ");
    if (end != std::string_view::npos) return text.substr(0, end);
    return text.ends_with('.') ? text.substr(0, text.size() - 1) : text;
}

std::string describe_values(const Option& option) {
    std::string text;
    const auto add_sentence = [&text](std::string sentence) {
        if (!text.empty()) text += ' ';
        sentence.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(sentence.front())));
        text += sentence + '.';
    };
    const bool named = option.value.find('|') != std::string::npos;
    const bool has_range = !option.allowed.empty() && !named;
    if (has_range) add_sentence(option.allowed);
    if (!option.words.empty() && !named) {
        std::string words;
        for (const std::string& word : option.words) words.append(words.empty() ? "" : ", ").append(word);
        add_sentence((option.takes_text || has_range ? "or " : "one of ") + words);
    }
    if (option.is_flag()) {
        if (option.default_value == "true") add_sentence("--no-" + option.name + " turns it off");
    } else if (!option.default_value.empty()) {
        add_sentence("default: " + option.default_value);
    }
    return text;
}

std::span<const ExitStatus> exit_statuses() {
    return kExitStatuses;
}

}  // namespace ccdt::server
