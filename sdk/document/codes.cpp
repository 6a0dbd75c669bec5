// SPDX-License-Identifier: Apache-2.0
// The one table of diagnostic codes: B00x-B03x config, B04x plugins, B06x data, B08x filters,
// B09x studies.
#include "document/codes.hpp"

namespace binnacle::document {

namespace {

constexpr CodeEntry entries[] = {
    {"B001", "JSON syntax",
     "The file is not valid JSON: a comma, quotation mark or bracket is missing or out of place.",
     "Correct the text at the given line and column. Comments are allowed, trailing commas are not."},
    {"B002", "duplicate key", "An object contains the same key twice. One of the two values would be lost.",
     "Delete or rename one of the two. The message gives the line of both."},
    {"B003", "file not found or unreadable", "A config, or a file named by `extends`, cannot be opened.",
     "Correct the name. A relative path starts at the folder of the file that contains it."},
    {"B004", "bad extends",
     "`extends` forms a cycle, is not a file name, or refers to something that is not an object.",
     "Give \"file.json\", \"file.json#/pointer\", \"#/pointer\" or a list of these, and break the cycle."},
    {"B005", "unknown variable", "A text uses \"${name}\", but `name` has no value or is misspelt.",
     "Define it under \"vars\" or give --var name=VALUE. A literal ${ is written $${."},
    {"B006", "wrong JSON type",
     "A value does not have the declared JSON type, for example a text instead of an object.",
     "Give the type that the message names. `binnacle describe TYPE` shows every parameter."},
    {"B007", "wrong unit dimension",
     "The unit does not have the dimension of the parameter, for example a length for an angle.",
     "Give a unit of the dimension that the message names, or a plain number in SI."},
    {"B008", "unknown unit or malformed quantity", "The text is not a number followed by a known unit.",
     "Write it like \"0.2 deg/h\", \"5 ug/sqrt(Hz)\" or \"3 m/s^2\"."},
    {"B009", "out of range", "The number is outside the range declared for the parameter.",
     "Give a number inside the range that the message names."},
    {"B010", "missing required key", "A parameter without a default is missing.",
     "Add the key. `binnacle create TYPE` prints a skeleton with all required keys."},
    {"B011", "unknown component type", "No loaded plugin has a component of this type.",
     "Correct the name, or name the plugin or its folder in \"plugins\" or BINNACLE_PLUGIN_PATH. `binnacle list` shows "
     "the known types."},
    {"B012", "unknown key", "The component or section does not declare this key.",
     "Correct the spelling or delete the key. `binnacle describe TYPE` lists all keys."},
    {"B013", "wrong array length", "A list has more or fewer elements than the block or parameter needs.",
     "Give as many elements as the message says."},
    {"B014", "not one of the choices", "The text is not one of the words that the parameter accepts.",
     "Use one of the words that the message lists."},
    {"B015", "unknown block", "A port, an initial value or a reference names a block that the filter does not have.",
     "Name a key of the filter's \"blocks\" or \"derived\"."},
    {"B016", "wrong port kind", "The block bound to a port is not of the port's kind.",
     "Bind a block of the kind that the message names. `binnacle describe TYPE` shows the ports."},
    {"B017", "required port not bound", "A required port of the model is not bound to a block.",
     "Add the port to the component's \"blocks\"."},
    {"B018", "block advanced by no process model", "No process model propagates the block.",
     "Add a process model for it. For a constant block, use `random_constant`."},
    {"B019", "block advanced by two process models", "Two process models advance the same block.",
     "Delete one of them, or bind it to another block."},
    {"B020", "unknown channel", "No source, transform or filter emits a channel with this name.",
     "Correct the name. `binnacle explain CONFIG` lists the channels."},
    {"B021", "channel lacks a field or has it in the wrong unit",
     "A component needs a field that the channel does not have, or has with a unit of another dimension.",
     "Bind another channel, or name the field and its unit where the channel is declared."},
    {"B022", "ambiguous type name", "Several plugins have a component with this name.",
     "Write the full name, plugin/component."},
    {"B023", "dependency cycle", "Derived blocks, transforms or filters depend on each other in a cycle.",
     "Break the cycle that the message lists."},
    {"B024", "bad time or window",
     "A time is not of the form \"228 s\" or \"start+60 s\", or a window ends before it begins.",
     "Correct the time. A window is [from, to] with from < to."},
    {"B025", "unknown component of a block",
     "`estimate`, `consider`, `init` or `sigma` names a component that the block does not have.",
     "Use the component names that the message lists."},
    {"B026", "initial value missing", "A block has neither an initial value nor a channel that provides it.",
     "Give `init` and `sigma`, or a channel for them."},
    {"B027", "unknown filter, reference or metric",
     "A reference, an evaluation or a metric names something that does not exist.",
     "Write a metric as FILTER/BLOCK.OUTPUT/STATISTIC. `binnacle explain CONFIG` lists the names."},
    {"B028", "version of the config", "\"binnacle\": 1 is missing, or the config is written for another version.",
     "Put \"binnacle\": 1 first in the config."},
    {"B029", "bad --set or --var",
     "The argument is not of the form PTR=VALUE or name=VALUE, or the pointer refers to nothing in the config.",
     "Begin the pointer with '/' and use the keys of the config. Quote the argument in the shell."},
    {"B030", "parameters refused by the model",
     "Each parameter is valid by itself, but the model refuses the combination.",
     "Read the model's reason in the message and its README."},
    {"B031", "unused", "Nothing uses a declared entry.", "Use it or delete it. It does no harm."},
    {"B032", "a component's note",
     "A component found something suspicious in its parameters or data, for example a model that fits the data poorly.",
     "Read the message. `binnacle explain` shows the figures that the component found."},
    {"B033", "too large",
     "The config exceeds a limit: 16 MiB and 500 000 values with all that it extends, 10 000 `extends` in chains of "
     "100, 16 MiB of text made of variables, 1000 members of a section, 2000 error states of a filter.",
     "Read the message. Put tables into data files, and describe differences between runs in a study."},
    {"B040", "plugin file not found", "The plugin is not in any of the searched folders.",
     "Build or install it, or add its folder to \"plugins\" or BINNACLE_PLUGIN_PATH."},
    {"B041", "guard missing", "The file is not a Binnacle plugin, or was built for another major version.",
     "Remove it from the plugin folder, or rebuild it with the SDK of this version."},
    {"B042", "guard mismatch",
     "The plugin was built with settings that prevent it from sharing memory with this program.",
     "Rebuild it with the compiler settings that the message names."},
    {"B043", "guard warning",
     "The plugin was built with other settings than this program. The difference is not known to do harm.",
     "Rebuild the plugin if its results are unexpected."},
    {"B044", "plugin that others could exchange",
     "Other users own the plugin's file or one of its folders, or may write to it. They could exchange the code, so "
     "the plugin is not loaded.",
     "Follow the message: use chmod, chown or a copy of your own."},
    {"B045", "plugin failed to register",
     "The plugin's registration threw an exception, or it registers other types than its BINNACLE_TYPES lists.",
     "Report the message to the plugin's author. The author corrects or deletes the list."},
    {"B046", "duplicate type", "Two components register the same full name.",
     "Remove one of the plugin files. The usual cause is an old copy in another folder."},
    {"B047", "plugin of a folder not loaded",
     "A library in a plugin folder cannot be loaded. This is a warning, unless the config uses a type that the library "
     "may contain.",
     "Rebuild or remove the file. The message gives the reason."},
    {"B048", "plugin of a config not trusted",
     "The config names a plugin that is not in a trusted folder and was not built here. To load it is to run its code.",
     "If you trust it, repeat the command with --allow-plugins. Otherwise build it from its source or remove it from "
     "the config."},
    {"B060", "data file missing", "A data file cannot be opened.",
     "Correct the path. Use \"vars\" and --var for the folder of the data."},
    {"B061", "truncated or corrupt data", "The file is truncated, or its checksum is wrong.",
     "Fetch or unpack the file again."},
    {"B062", "wrong column count or bad number",
     "A line has more or fewer columns than the header, or text instead of a number.",
     "Correct the line that the message names, or the declaration of the columns."},
    {"B063", "time running backwards", "A sample is older than the sample before it.",
     "Sort the file by time, or correct the time column and its unit."},
    {"B064", "NaN in a field", "A sample contains NaN or infinity in a field that needs a number.",
     "Correct the data, or declare the value that marks invalid samples."},
    {"B065", "gap", "The time between two samples is longer than `max_gap`.",
     "If the gap is expected, raise `max_gap`. Otherwise look for lost data."},
    {"B066", "no samples", "A source emitted no sample, or none in its window.",
     "Check the file, the window and the time offset."},
    {"B067", "connection lost",
     "A live source cannot connect, or its connection closed. The program tries again every second.",
     "Check the sender and the address."},
    {"B080", "filter broken", "The estimate or the covariance is not finite, not positive or out of bounds.",
     "Look at the step and the block that the message names. Usual causes are a noise of zero and wrong initial "
     "values."},
    {"B081", "filter never started", "At least one block never received its initial value.",
     "Check the channel that the message names, its `max_age` and the window of the data. An alignment emits only "
     "after its stationary phase and, if it needs one, a course."},
    {"B082", "snapshot does not match",
     "The bytes are not a snapshot, are damaged, or belong to another composition, another plugin build or another "
     "version.",
     "Restore the snapshot with the config, plugins and program that made it. A damaged snapshot cannot be restored."},
    {"B083", "a model's note",
     "A model reports a condition in the run, or an invalid sample. Equal notes of one component are combined into one "
     "warning: it appears at once, and again at the end with the time of the first note and their number.",
     "Read the message and the plugin's README."},
    {"B084", "checkpoint does not match",
     "The file is not a checkpoint, is incomplete or damaged, or belongs to another config, other data, options, "
     "plugins, another version or another type of machine.",
     "Resume with the config, data and program of the original run, or start the run again without the checkpoint."},
    {"B090", "unknown variant", "--variant or a table names a variant that the study does not have.",
     "Use one of the names that the message lists. For a cell without a variant, use \"\"."},
    {"B091", "variants of one name", "Two variants of a study have the same name, so one of them would be lost.",
     "Rename one of them. A variant made of dimensions has the name \"A B\", with one choice of each dimension."},
    {"B092", "journal of another study",
     "The folder of --out contains the journal of a study with another config, seed, program or plugin.",
     "Give another folder, or delete the journal to start again."},
    {"B093", "a run of a study broke", "A run of the study could not be finished. The other runs continued.",
     "Repeat this run alone with the command in the message. Its summary gives the details."},
    {"B094", "adaptive noise in a covariance analysis",
     "A noise estimator needs residuals, and a covariance analysis has none.",
     "Remove `noise` from the measurement for the analysis, or run a study."},
    {"B100", "locked out",
     "A measurement, or a row or key that its gate tests, was refused several times in a row up to the end. The filter "
     "is `lost` if this is the whole measurement or most of its rows, and `doubtful` if other rows pass.",
     "Either the estimate is wrong (check the start, holes in the input and the other reasons) or the measurement is "
     "wrong (check its clock, axes, units, lever arm and standard deviations)."},
    {"B101", "never accepted", "The filter refused every sample of a measurement.",
     "Look at `last_reason` in the summary. Usual causes are standard deviations of 0, wrong units or axes, and an "
     "initial estimate far from the truth."},
    {"B102", "mostly refused", "The gate refused more than half of a measurement's rows.",
     "Look at the RMS of the normalized innovations in the summary. It shows the factor by which the standard "
     "deviations may be too small. Otherwise the estimate is wrong."},
    {"B103", "innovations larger than their noise",
     "Over a window of at least 50 samples and 10 s, the mean of NIS over its rows is larger than the specified noise "
     "can explain. The filter is `lost` if NIS of the latest window exceeds `beyond_reason` of `trust`.",
     "The summary gives the standard deviation that would fit each row. If the innovations grow with motion, check the "
     "model, the clock, and the lever arm: one that the config does not have shows in turns."},
    {"B104", "biased innovations",
     "Over a window, the mean innovation of a row is further from zero than noise and what is `systematic` can "
     "explain.",
     "A constant error is not modelled. Check for a bias, a lever arm, a mounting angle, a clock offset at constant "
     "speed or a receiver with an offset."},
    {"B105", "correlated innovations",
     "Over a window, the innovations of a row are correlated in time more than white noise can explain.",
     "The measurement's errors are correlated in time (by a receiver's own filter or multipath), or the process noise "
     "is too small."},
    {"B106", "recovered",
     "A measurement was locked out. The filter increased the covariance until the measurement passed again. It is "
     "`lost` if nothing confirms what it accepted: [who is right](trust.md#who-is-right).",
     "Look for the cause before this time. The estimates from the first refusal to the recovery are wrong, or later "
     "ones."},
    {"B107", "locked out for a while",
     "A measurement, or a row or key, was refused several times in a row, and passes again.",
     "Look at the data at the time in the message. Either the receiver jumped, froze or was spoofed, or the estimate "
     "was temporarily wrong."},
    {"B108", "hole in the input", "The driving input had a hole, which the filter bridged with held rates.",
     "Look for lost data. The estimates after the hole are as good as the rates before and after it allow."},
    {"B109", "frozen input",
     "The driving input repeated its numbers to the bit, after they had changed from sample to sample.",
     "Check the sensor and its logger. A sensor that hangs repeats its last sample."},
    {"B110", "unaided", "The filter has measurements, but used no sample of any of them.",
     "Look at the outcomes in the summary and at the time spans of the channels."},
    {"B111", "implausible number",
     "The number is orders of magnitude away from the values of such a sensor or vehicle.",
     "Write the unit: \"0.3 deg/sqrt(h)\". A number without a unit is SI."},
    {"B112", "no aiding of position",
     "A position block integrates a velocity block, and no measurement observes the position.",
     "Add a measurement of the position. Dead reckoning is legal, but its error grows with time or distance."},
    {"B113", "gate without recovery", "A measurement has a gate and `\"recover\": false`.",
     "Delete `recover`. If refusals are expected (for example a zero-velocity update whose gate tests the detector), "
     "add the measurement to `except` of the filter's `trust`."},
    {"B114", "no time in common",
     "No sample of a measurement or reference was used, and their times do not overlap the filter's driving input. "
     "Only a run finds this, because `check` reads no rows.",
     "Compare the time spans in the message. Check `offset` and `unit` of the source's `time`. GPS time is ahead of "
     "UTC by the leap seconds."},
    {"B115", "restarted",
     "Recovery failed several times in a row, or a hole was too long to bridge. The filter started again from initial "
     "values.",
     "Look at the reasons before it and at the data at the time in the message."},
    {"B116", "stopped",
     "The driving input had a hole longer than `longest_bridge`, and no initial values came after it.",
     "Look for lost data. Give the blocks an `\"again\"` from a channel that also emits in motion."},
    {"B117", "silent measurement",
     "For a long time no sample of a measurement was usable, and the uncertainty of the states that it observes grew "
     "much larger.",
     "Look for the outage in the data. If the models are right, the estimates during the outage have the sigma that "
     "the filter gives."},
    {"B118", "input ended",
     "The driving input ended, or had no complete sample any more, long before the newest sample.",
     "Look for lost data or NaN at the end. The estimates end with the input."},
    {"B119", "likely cause: a clock",
     "A filter is not `ok`, and the velocities of a measurement fit the inertial input much better after a shift in "
     "time.",
     "Compare the time labels of the two: leap seconds, `offset` and `unit` of a source's `time`, the delay of the "
     "receiver. The data do not show which of the two clocks is wrong."},
    {"B120", "likely cause: axes, signs or scales",
     "A filter is not `ok`, and fields of a channel contradict each other or the inertial input. A swapped field, a "
     "wrong sign or a wrong unit explains the contradiction.",
     "Compare the fields in the message with the sensor's manual: order, axes, signs, units."},
    {"B121", "nothing to evaluate",
     "A span of `evaluate` contains no sample of a reference, though the reference has samples at other times.",
     "Compare `after`, `until` and the windows with the time span of the filter. `\"start+60 s\"` counts from the "
     "start of the filter. Other times are those of the data."},
    {"B122", "later than the history",
     "Samples of a channel were not used, because they came later than the longest `history` of the config's filters.",
     "Make `history` longer than the largest delay, or find the cause of the delay."},
    {"B123", "live estimates lag",
     "`steps` of `history` limits the steps for one arrival. With this limit, live estimates lagged behind by more "
     "than the history, and late samples were refused in the meantime.",
     "Allow more `steps`, or find out why so many samples come late. Without `steps` there is no limit."},
    {"B124", "invalid latency",
     "The field that `latency` names was NaN, infinite or negative. The sample was treated as if it arrived at its own "
     "time.",
     "Check the field: its unit must be a time, and every sample must set it."},
    {"B125", "no segment",
     "A metric of segments has no value: no reference gives position and attitude at the same time, or the path is "
     "shorter than the shortest segment.",
     "Use one channel as the reference of both blocks. Give shorter `lengths` in `segments` of `evaluate`."},
    {"B126", "P is not a covariance",
     "P of the filter contains a correlation beyond one, or a combination of components with a negative variance, by "
     "more than 1e-6 of a component's own variance; beyond 1e-3 the filter is `lost`. P is checked every 1024 steps "
     "and before a verdict.",
     "Check the initial covariance. If it is valid, rounding is the cause: `\"covariance\": \"ud\"` or "
     "`\"square_root\"` keeps P positive semidefinite."},
    {"B127", "too few digits in P",
     "The predicted variance of a measurement was at least 1e15 times the variance of its own noise. The form `joseph` "
     "has too few digits for both, so the sigmas after the update are zero or wrong.",
     "Set `\"covariance\"` of the filter to `\"ud\"` or `\"square_root\"`, which have enough digits, or give an "
     "initial sigma closer to the true uncertainty."},
    {"B128", "innovations smaller than their noise",
     "The mean NIS of a measurement over a run is less than half of the expected value. The verdict does not change: "
     "sigmas that are too large cost accuracy, but claim none.",
     "Reduce the standard deviations or the process noise, as the note says. Correlated errors, such as those of a "
     "receiver, also give small innovations: then leave the sigmas, or model the errors as a state. `except` of "
     "`trust` suppresses the note."},
    {"B129", "'after' long before the run",
     "`after` of `evaluate` is a time of the data that lies farther before the start of the filter than the run lasts, "
     "so it leaves out nothing.",
     "`\"start+20 s\"` counts from the start of the filter. Other times are those of the data."},
    {"B130", "adaptive noise in tuning",
     "A noise estimator computes R of a measurement from its innovations, so R follows every tuned parameter.",
     "Delete its `noise` for tuning (`--set …/noise=null`), or tune with withheld samples or a metric."},
    {"B131", "nothing to tune by",
     "The objective of `tune` has no value, because no sample was accepted, none was withheld, or nothing was scored.",
     "Look at the outcomes in the summary of `run`. The objective `withheld` needs a measurement with `withhold`, a "
     "metric needs a reference."},
    {"B143", "input that cannot be repeated",
     "A smoother over the whole run needs its input twice, but live sources and `--input` give it once.",
     "Use `\"smoother\": {\"type\": \"fixed_lag\", …}`, or smooth the records of a recorded run."},
    {"B144", "recorded input",
     "A file of `--input` was not made by `run --record-input`, belongs to another config, or ends in the middle of a "
     "line.",
     "Use the config of the recording. If the file was cut short, the complete lines are run."},
    {"B145", "lines lost", "A receiver of live output was too slow or absent, so the oldest lines were dropped.",
     "Make the receiver read faster, give the sink a larger `buffer` or fewer samples, or write to a file, which loses "
     "no lines."},
    {"B146", "no receiver",
     "A connection of live output broke, its device vanished, the disk is full, or no receiver connected.",
     "Check the receiver, the device or the disk. TCP connections and serial devices are tried again every second. The "
     "run continues."},
    {"B147", "noise larger than claimed",
     "A row that was refused again and again scatters by more than the standard deviation that it claims. Its noise "
     "was increased to what it scatters; the covariance was not opened.",
     "Give the measurement a larger `sigma`, or scale the deviations that the receiver reports (`scale`, `floor`)."},
};

}  // namespace

std::span<const CodeEntry> diagnostic_codes() { return entries; }

}  // namespace binnacle::document
