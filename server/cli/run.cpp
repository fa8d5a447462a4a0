// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/cli/run.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <map>
#include <new>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <unistd.h>

#include "api/json/json_document.h"
#include "api/map/shapefile_reader.h"
#include "api/output/archive.h"
#include "core/base/thread_executor.h"
#include "server/cli/arguments.h"
#include "server/cli/console.h"
#include "server/cli/decoding.h"
#include "server/cli/files.h"
#include "server/cli/help.h"
#include "server/cli/interruption.h"
#include "server/cli/messages.h"
#include "server/cli/request.h"
#include "server/processes/signals.h"

namespace ccdt::server {
namespace {

/// An input, its output, and the format of the output.
struct Task {
    std::string input;  ///< empty: there is none
    std::string output;
    const api::FileFormat* format = nullptr;
};

/// An error with the exit status that it causes.
struct Failed {
    int status;
    Error error;
};

tl::unexpected<Failed> failed(int status, Error error) {
    return tl::unexpected<Failed>(Failed{status, std::move(error)});
}

tl::unexpected<Failed> wrong_usage(std::string message) {
    return failed(kWrongUsage, {ErrorCode::Malformed, std::move(message), {}});
}

/// Stands for the name of a file of a split drawing, in the name of an output.
constexpr std::string_view kInk = "{ink}";

void replace_all(std::string& text, std::string_view placeholder, std::string_view value) {
    for (std::size_t at = 0; (at = text.find(placeholder, at)) != std::string::npos; at += value.size())
        text.replace(at, placeholder.size(), value);
}

/// Returns the name of the output of an input. A folder stands for the files `{name}` in it, with the suffix of the
/// format. Replaces `{name}` by the name of the input without folder and suffix.
std::string output_for(const Command& command, const Arguments& arguments, const std::string& input) {
    std::string output = arguments.output.value_or(std::string(kStandardStream));
    std::error_code missing;
    if (output.ends_with('/') || std::filesystem::is_directory(output, missing)) {
        const auto format = find_format(command, arguments, std::string(kStandardStream));
        const bool is_split = arguments.find("split") != nullptr;
        output += std::string(output.ends_with('/') ? "" : "/") + (is_split ? "{name}-{ink}." : "{name}.") +
                  std::string((*format)->extension);
    }
    replace_all(output, "{name}", input == kStandardStream ? "stdin" : std::filesystem::path(input).stem().string());
    return output;
}

/// Returns a text that is the same for all names of a target.
std::string position_of(const api::OutputTarget& target) {
    if (target.descriptor >= 0) return std::to_string(target.descriptor);
    std::error_code unresolved;
    const auto path = std::filesystem::weakly_canonical(target.path, unresolved);
    return unresolved ? target.path : path.string();
}

/// Pairs each input with its output.
tl::expected<std::vector<Task>, Failed> plan_tasks(const Command& command, const Arguments& arguments) {
    std::vector<std::string> inputs = arguments.inputs;
    if (std::ranges::count(inputs, kStandardStream) > 1) return wrong_usage("standard input (-) is given twice");
    if (inputs.empty()) {
        const auto is_given = [&](std::string_view name) { return arguments.find(name) != nullptr; };
        const bool has_shape = is_given("domain") || is_given("polygon") || is_given("geometry");
        const bool needs_none = command.name == "sample" ? has_shape : is_given("sets");
        if (!needs_none)
            return wrong_usage(std::string(command.name) +
                               " needs an input: the name of a file, or - for standard input" +
                               (command.name == "sample" ? ", or one of --domain, --polygon and --geometry" : ""));
        inputs.emplace_back();
    }
    std::vector<Task> tasks;
    std::map<std::string, std::string> input_of;  ///< by position_of() the output
    for (const std::string& input : inputs) {
        const Task task{input, output_for(command, arguments, input)};
        if (arguments.find("split") != nullptr && task.output.find(kInk) == std::string::npos &&
            !task.output.ends_with(".zip") && task.output != kStandardStream)
            return wrong_usage(
                "--split makes several files: use {ink} in --output, as in 'out/{name}-{ink}.svg', or "
                "a name that ends with .zip, with --format");
        const api::OutputTarget target = output_target(task.output);
        if (target.is_replaced || target.descriptor >= 0) {
            const auto [other, is_new] = input_of.try_emplace(position_of(target), input);
            if (!is_new)
                return wrong_usage(other->second + " and " + input + " have the same output, " + target.path +
                                   "; use {name} in --output, as in 'out/{name}.svg'");
        }
        std::error_code none;
        if (target.is_replaced && std::filesystem::equivalent(input, target.path, none))
            return wrong_usage("--output " + task.output + " would replace the input " + input);
        tasks.push_back(task);
    }
    return tasks;
}

/// Finds the formats of all outputs, and checks that they can be written.
tl::expected<void, Failed> check_outputs(const Command& command, const Arguments& arguments, std::vector<Task>& tasks) {
    for (Task& task : tasks) {
        const auto format = find_format(command, arguments, task.output);
        if (!format) return failed(kWrongUsage, format.error());
        task.format = *format;
        if (!arguments.output && isatty(STDOUT_FILENO) != 0 && !is_text(**format))
            return wrong_usage("standard output is a terminal, and " + std::string((*format)->title) +
                               " is not text; --output FILE writes to a file");
        if (auto checked = check_output(task.output); !checked) return failed(kOutputFailed, checked.error());
    }
    return {};
}

/// Makes errors about a format that was not given refer to the output, whose suffix chose the format.
void blame_output(Error& error, const Task& task) {
    if (error.field == "format" || error.field == "/format") {
        error.message =
            "output " + task.output + " sets --format=" + std::string(task.format->name) + ": " + error.message;
        error.field = "output";
    }
    for (Error& other : error.others) blame_output(other, task);
}

/// Returns the exit status for an error of a computation.
int status_of(const Error& error, std::span<const Option> options) {
    switch (error.code) {
        case ErrorCode::Malformed:
            return describe_error(error, options).option.empty() ? kInputFailed : kWrongUsage;
        case ErrorCode::NotAcceptable:
            return kWrongUsage;
        case ErrorCode::Unsupported:
            return kInputFailed;
        default:
            return kFailed;
    }
}

/// Computes the answers of a command.
class Runner {
public:
    Runner(const Command& command, std::span<const Option> options, Arguments arguments, Interruption& interruption,
           Messages& messages)
        : command_(command),
          options_(options),
          arguments_(std::move(arguments)),
          interruption_(interruption),
          messages_(messages),
          threads_(arguments_.threads) {}

    /// @returns  exit status
    int run() {
        auto tasks = plan_tasks(command_, arguments_);
        if (!tasks) return report({}, tasks.error());
        // The decoder starts while options and input are read.
        if (command_.name == "halftone") {
            if (auto started = decoding_.start(); !started) return report({}, {kFailed, started.error()});
        }
        if (auto checked = check_outputs(command_, arguments_, *tasks); !checked) return report({}, checked.error());
        if (auto read = read_value_files(arguments_); !read)
            return report({}, {status_of(read.error(), options_), read.error()});
        int status = 0;
        for (const Task& task : *tasks) {
            const auto answered = answer(task);
            if (answered) continue;
            const int failure = report(task.input, answered.error());
            if (status == 0) status = failure;
            if (failure == kWrongUsage) break;  // an option that is wrong for one input is wrong for all
        }
        return status;
    }

private:
    int report(const std::string& input, const Failed& failed) {
        std::vector<Error> errors{failed.error};
        errors.insert(errors.end(), failed.error.others.begin(), failed.error.others.end());
        for (const Error& error : errors) {
            auto [option, message] = describe_error(error, options_);
            if (!option.empty()) add_value(option, message);
            if (error.field.starts_with("/points/") && arguments_.find("domain") == nullptr)
                message += "; without --domain, it is a torus of 1 x 1";
            const bool is_about_input = option.empty() || failed.status != kWrongUsage;
            messages_.report_error({failed.status, is_about_input ? input : "", std::move(option), std::move(message)});
        }
        return failed.status;
    }

    /// Completes a message such as "--sites must be a number" by the value that is not valid.
    void add_value(std::string_view option, std::string& message) const {
        constexpr std::size_t kLongest = 64;
        const Arguments::Given* const given = arguments_.find_given(option.substr(2));
        if (given == nullptr || given->typed.size() > kLongest ||
            !message.starts_with(std::string(option) + " must be ") || message.find(", not ") != std::string::npos)
            return;
        message += ", not '" + given->typed + "'";
        std::error_code none;
        if (given->option->takes_json && std::filesystem::exists(given->typed, none))
            message += "; @ before the name of a file reads it: @" + given->typed;
    }

    /// Whether the answer has the format of the input by default, which its suffix may not tell.
    bool keeps_format(const Task& task) const {
        const auto suffix = [](const std::string& file) { return std::filesystem::path(file).extension(); };
        return command_.name == "choose" && suffix(task.input) == suffix(task.output);
    }

    tl::expected<void, Failed> answer(const Task& task) {
        const auto start = std::chrono::steady_clock::now();
        std::optional<std::string> input;
        if (!task.input.empty()) {
            auto read = read_file(task.input, arguments_.memory,
                                  [this](std::string_view head) { return check_head(command_, head); });
            if (!read) return failed(status_of(read.error(), options_), read.error());
            input = *std::move(read);
            if (auto checked = check_memory(input->size() + parsing_memory(*input)); !checked)
                return failed(kFailed, checked.error());
        }
        Arguments arguments = arguments_;
        if (command_.name == "sample" && input && input->starts_with(api::kZipSignature)) {
            if (auto converted = convert(*input, arguments); !converted) return converted;
        }
        const auto split = std::ranges::find(options_, "split", &Option::member);
        const bool is_split = task.output.find(kInk) != std::string::npos && split != options_.end();
        const bool sets_format =
            task.output != kStandardStream && arguments.find("format") == nullptr && !keeps_format(task);
        bool is_set = false;  // whether a body of options has what the output says
        if (sets_format && input && arguments.given.empty()) {
            auto set = set_output(command_, *task.format, is_split, *input);
            if (!set) {
                blame_output(set.error(), task);
                return failed(kWrongUsage, set.error());
            }
            is_set = *set;
        }
        if (sets_format && !is_set)
            arguments.given.push_back(
                {&*std::ranges::find(options_, "format", &Option::member), std::string(task.format->name)});
        if (is_split && !is_set && arguments.find("split") == nullptr) arguments.given.push_back({&*split, "ink"});
        const auto request = build_request(command_, arguments, input ? &*input : nullptr);
        if (!request) return failed(status_of(request.error(), options_), request.error());
        input.reset();
        OutputFile output(task.output, interruption_);
        auto computed = compute(task, *request, is_split ? nullptr : &output);
        std::size_t written = output.written();
        std::vector<std::string> files;
        if (computed && is_split) {
            for (const api::ArchivedFile& file : api::read_archive(computed->body)) {
                files.push_back(file_of(task.output, file));
                if (auto saved = save(files.back(), file); !saved) return failed(kOutputFailed, saved.error());
                written += file.bytes.size();
            }
        }
        if (!computed && sets_format) blame_output(computed.error(), task);
        if (!computed)
            return failed(output.has_failed() ? kOutputFailed : status_of(computed.error(), options_),
                          computed.error());
        const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
        report_notes(task.input, computed->warnings, computed->repaired);
        messages_.report_result({task.input, task.output, computed->media_type, written, computed->sites, taken.count(),
                                 computed->dots, computed->plot, files});
        return {};
    }

    /// Converts a zipped shapefile to GeoJSON, and removes the option `object`, which the conversion uses.
    tl::expected<void, Failed> convert(std::string& archive, Arguments& arguments) {
        const std::string* const object = arguments.find("object");
        auto text = decoding_.read_shapefile(archive, object == nullptr ? "" : *object, arguments.memory);
        if (!text) {
            const ErrorCode code = text.error().code;
            const bool is_input = code != ErrorCode::Internal && code != ErrorCode::LimitExceeded;
            return failed(is_input ? kInputFailed : kFailed, text.error());
        }
        archive = *std::move(text);
        std::erase_if(arguments.given, [](const auto& given) { return given.option->name == "object"; });
        return {};
    }

    Result<void> check_memory(std::size_t needed) const {
        constexpr std::size_t kMebibyte = std::size_t{1} << 20;
        if (needed <= arguments_.memory) return {};
        return failure(ErrorCode::LimitExceeded, "the request may need " + std::to_string(needed / kMebibyte + 1) +
                                                     " MiB of memory; the limit (--memory) is " +
                                                     std::to_string(arguments_.memory / kMebibyte) + " MiB");
    }

    /// Returns the name under which a file of a split drawing is written.
    /// @param pattern  name of the output, with kInk
    static std::string file_of(std::string pattern, const api::ArchivedFile& file) {
        replace_all(pattern, kInk, std::filesystem::path(file.name).stem().string());
        return pattern;
    }

    Result<void> save(const std::string& name, const api::ArchivedFile& file) {
        OutputFile output(name, interruption_);
        auto begun = output.begin({});
        if (begun) begun = output.write(file.bytes);
        return begun ? output.finish() : begun;
    }

    /// @param output  receives the answer; null: the answer is returned with its body
    Result<api::Answer> compute(const Task& task, const ApiRequest& request, OutputFile* output) {
        const auto parsed = parse_request(command_, request, arguments_.limits);
        if (!parsed) return tl::unexpected(parsed.error());
        if (auto checked = check_memory(request.body.size() + (*parsed)->cost().memory); !checked)
            return tl::unexpected(checked.error());
        const Control control{
            .stop = {},
            .progress = [&](const Progress& progress) { messages_.report_progress(task.input, progress.done()); },
            .executor = &threads_};
        api::Timings timings;
        auto answer = (*parsed)->run(decoding_.functions(), control, timings, output);
        if (!answer || output == nullptr) return answer;
        if (!answer->streamed) {
            if (auto begun = output->begin(*answer); !begun) return tl::unexpected(begun.error());
            if (auto written = output->write(answer->body); !written) return tl::unexpected(written.error());
        }
        if (auto finished = output->finish(); !finished) return tl::unexpected(finished.error());
        return answer;
    }

    /// Prints all warnings, and one line about repairs, of which there may be many. Repairs of a mesh have an empty
    /// pointer.
    /// @param warnings, repairs  lists of objects with the member `detail`, as JSON; empty if there are none
    void report_notes(const std::string& input, const std::string& warnings, const std::string& repairs) {
        if (const auto list = api::JsonDocument::parse(warnings)) {
            for (const api::JsonValue note : list->root()) {
                const std::string& position = note.find("pointer").value().text();
                messages_.warn(input, position + (position.empty() ? "" : ": ") + note.find("detail").value().text());
            }
        }
        const auto list = api::JsonDocument::parse(repairs);
        if (!list) return;
        const std::size_t others = list->root().size() - 1;
        const api::JsonValue note = *list->root().begin();
        const bool is_mesh = note.find("pointer").value().text().empty();
        const std::string first = note.find("detail").value().text();
        const std::string more = others == 1 ? " other fault" : " other faults";
        messages_.warn(input, std::string(is_mesh ? "the mesh" : "the area") + " was repaired: " + first +
                                  (others == 0 ? "" : "; and " + std::to_string(others) + more) +
                                  (is_mesh ? "" : "; --invalid=reject refuses it"));
    }

    const Command& command_;
    const std::span<const Option> options_;
    Arguments arguments_;
    Interruption& interruption_;
    Messages& messages_;
    ThreadExecutor threads_;
    Decoding decoding_;
};

/// Returns the style of messages that a command line requests, even if it is not valid otherwise.
Messages::Style style_of(std::span<const char* const> arguments) {
    const auto is_given = [&](std::string_view name) {
        return std::ranges::find(arguments, name, [](const char* each) { return std::string_view(each); }) !=
               arguments.end();
    };
    if (is_given("--json")) return Messages::Style::Json;
    return is_given("--quiet") || is_given("-q") ? Messages::Style::Quiet : Messages::Style::Text;
}

}  // namespace

int run_command(const Command& command, std::span<const char* const> arguments) {
    const auto options = options_of(command);
    Interruption interruption;
    Messages messages(style_of(arguments), interruption);
    try {
        auto parsed = parse_arguments(options, arguments);
        if (!parsed) {
            messages.report_error({kWrongUsage, {}, parsed.error().field, parsed.error().message});
            return kWrongUsage;
        }
        if (parsed->help) return print(command_help(command, terminal_width()));
        // A broken pipe at standard output ends the program, but not one at standard error. A file that exceeds a limit
        // of its size (ulimit -f) is an error like a full disk.
        ignore_signals(std::array{SIGPIPE, SIGXFSZ});
        return Runner(command, options, *std::move(parsed), interruption, messages).run();
    } catch (const std::bad_alloc&) {
        messages.report_error({kFailed, {}, {}, "there is not enough memory"});
    } catch (const std::exception& exception) {
        messages.report_error({kFailed, {}, {}, exception.what()});
    }
    return kFailed;
}

}  // namespace ccdt::server
