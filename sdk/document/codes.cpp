// SPDX-License-Identifier: Apache-2.0
// The one table of diagnostic codes: B00x-B03x config, B04x plugins, B06x data, B08x filters,
// B09x studies.
#include "document/codes.hpp"

namespace binnacle::document {

namespace {

constexpr CodeEntry entries[] = {
    {"B001", "JSON syntax", "The file is not JSON: a comma, quote or bracket is missing or out of place.",
     "Correct the text at the given line and column; comments are allowed, trailing commas are not."},
    {"B002", "duplicate key", "The same key stands twice in one object; one of them would be lost.",
     "Delete or rename one of the two; the message gives the line of both."},
    {"B003", "file not found or unreadable", "A config, or a file named by `extends`, cannot be opened.",
     "Correct the name; a relative path starts at the folder of the file that names it."},
    {"B004", "bad extends",
     "`extends` forms a cycle, is not a file name, or points at something that is not an object.",
     "Give \"file.json\", \"file.json#/pointer\", \"#/pointer\" or a list of these, and break the cycle."},
    {"B005", "unknown variable", "A text uses \"${name}\", but nothing gives `name` a value, or it is misspelt.",
     "Define it under \"vars\" or give --var name=VALUE; a literal ${ is written $${."},
    {"B006", "wrong JSON type", "A value is of another JSON type than the one declared, a text for an object, say.",
     "Give the type that the message names; `binnacle describe TYPE` shows every parameter."},
    {"B007", "wrong unit dimension", "The unit measures another thing than the parameter: a length for an angle.",
     "Give a unit of the dimension that the message names, or a plain number in SI."},
    {"B008", "unknown unit or malformed quantity", "The text is not a number followed by a unit that is known.",
     "Write it like \"0.2 deg/h\", \"5 ug/sqrt(Hz)\" or \"3 m/s^2\"."},
    {"B009", "out of range", "The number is outside the range declared for the parameter.",
     "Give a number inside the range that the message names."},
    {"B010", "missing required key", "A parameter without a default is not given.",
     "Add the key; `binnacle create TYPE` prints a skeleton with every required one."},
    {"B011", "unknown component type", "No loaded plugin has a component of this type.",
     "Correct the name, or make the plugin known through \"plugins\" or BINNACLE_PLUGIN_PATH; see `binnacle "
     "list`."},
    {"B012", "unknown key", "The component or section declares no such key.",
     "Correct the spelling or delete the key; `binnacle describe TYPE` lists all of them."},
    {"B013", "wrong array length", "A list has more or fewer elements than the block or parameter needs.",
     "Give as many elements as the message says."},
    {"B014", "not one of the choices", "The text is not among the words that the parameter accepts.",
     "Use one of the words that the message lists."},
    {"B015", "unknown block", "A port, an initial value or a reference names a block that the filter does not have.",
     "Name a key of the filter's \"blocks\" or \"derived\"."},
    {"B016", "wrong port kind", "The block bound to a port is of another kind than the port takes.",
     "Bind a block of the kind that the message names; `binnacle describe TYPE` shows the ports."},
    {"B017", "required port not bound", "A port that the model cannot do without is left open.",
     "Add the port to the component's \"blocks\"."},
    {"B018", "block advanced by no process model", "Nothing says how the block moves in time.",
     "Add a process model for it; `random_constant` if it does not move."},
    {"B019", "block advanced by two process models", "Two process models claim the same block.",
     "Delete one of them, or bind it to another block."},
    {"B020", "unknown channel", "No source, transform or filter emits a channel of this name.",
     "Correct the name; `binnacle explain CONFIG` lists the channels."},
    {"B021", "channel lacks a field or has it in the wrong unit",
     "A component needs a field of the channel which is not there, or which measures another thing.",
     "Bind another channel, or name the field and its unit where the channel is declared."},
    {"B022", "ambiguous type name", "Several plugins have a component of this name.",
     "Write the full name, plugin/component."},
    {"B023", "dependency cycle", "Derived blocks, transforms or filters depend on each other in a cycle.",
     "Break the cycle that the message spells out."},
    {"B024", "bad time or window",
     "A time is not of the form \"228 s\" or \"start+60 s\", or a window ends before it begins.",
     "Correct the time; a window is [from, to] with from < to."},
    {"B025", "unknown component of a block",
     "`estimate`, `consider`, `init` or `sigma` names no component of the block.",
     "Use the component names that the message lists."},
    {"B026", "initial value missing", "A block has neither an initial value nor a channel to take it from.",
     "Give `init` and `sigma`, or a channel for them."},
    {"B027", "unknown filter, reference or metric",
     "A reference, an evaluation or a metric names something that is not there.",
     "Metrics read FILTER/BLOCK.OUTPUT/STATISTIC; `binnacle explain CONFIG` lists the names."},
    {"B028", "version of the config", "\"binnacle\": 1 is missing, or the config is written for another version.",
     "Put \"binnacle\": 1 first in the config."},
    {"B029", "bad --set or --var",
     "An option does not read PTR=VALUE or name=VALUE, or aims at something that is not there.",
     "A pointer starts with '/', its keys are those of the config; quote the option in the shell."},
    {"B030", "parameters refused by the model",
     "Every parameter is right by itself, but the model refuses them together.",
     "Read the model's reason in the message and its README."},
    {"B031", "unused", "Something is declared that nothing reads.", "Use it or delete it; it does no harm."},
    {"B032", "a component's note",
     "A component found something suspicious in what it was given: a model that fits data poorly, say.",
     "Read the message; `binnacle explain` shows the figures that the component found."},
    {"B033", "too large",
     "A config is larger than what it may take: 16 MiB and 500 000 values with all that it extends, 10 000 `extends` "
     "in chains "
     "of 100, 16 MiB of texts made of variables, 1000 members of a section, 2000 error states of a filter.",
     "Read the message; tables belong into files of data, and what differs between runs into a study."},
    {"B040", "plugin file not found", "The plugin is not in any of the folders searched.",
     "Build or install it, or add its folder to \"plugins\" or BINNACLE_PLUGIN_PATH."},
    {"B041", "guard missing", "The file is not a Binnacle plugin, or is one for another major version.",
     "Remove it from the plugin folder, or rebuild it with this version's SDK."},
    {"B042", "guard mismatch",
     "The plugin was built with settings under which it cannot share memory with this program.",
     "Rebuild it with the compiler settings that the message names."},
    {"B043", "guard warning",
     "The plugin was built with other settings than this program, harmless as far as is known.",
     "Rebuild it if something is odd."},
    {"B044", "plugin that others could exchange",
     "Others may write the plugin's file or a folder that it lies in, or own it, and could exchange its code, so it is "
     "not loaded.",
     "Do what the message says: chmod, chown, or a copy of your own."},
    {"B045", "plugin failed to register",
     "The plugin's registration threw, or it registers other types than its BINNACLE_TYPES lists.",
     "Report the message to the plugin's author, who corrects the list or deletes it."},
    {"B046", "duplicate type", "Two components register the same full name.",
     "Remove one of the plugin files; an old copy in another folder is the usual cause."},
    {"B047", "plugin of a folder not loaded",
     "A library that was found in a plugin folder cannot be loaded. A warning, unless the config has a type that it "
     "may "
     "bring.",
     "Rebuild or remove the file; the message gives the reason."},
    {"B048", "plugin of a config not trusted",
     "The config names a plugin that lies in no trusted folder and was not built here. Loading it runs its code.",
     "If you trust it, repeat the command with --allow-plugins; else do without it, or build it from its source."},
    {"B060", "data file missing", "A file of samples cannot be opened.",
     "Correct the path; \"vars\" and --var are made for the folders of data."},
    {"B061", "truncated or corrupt data", "The file ends in the middle, or its checksum is wrong.",
     "Fetch or unpack the file again."},
    {"B062", "wrong column count or bad number",
     "A line has more or fewer columns than the header, or text for a number.",
     "Correct the line that the message names, or the declaration of the columns."},
    {"B063", "time running backwards", "A sample is older than the one before it.",
     "Sort the file by time, or correct the time column and its unit."},
    {"B064", "NaN in a field", "A sample has a NaN or an infinity where a number is needed.",
     "Correct the data, or declare the value that marks invalid samples."},
    {"B065", "gap", "Two samples are further apart than `max_gap`.",
     "Nothing if the data are like that; raise `max_gap` otherwise."},
    {"B066", "no samples", "A source gave no sample at all, or none in its window.",
     "Look at the file, the window and the time offset."},
    {"B067", "connection lost",
     "Nobody is at the address of a live source, or who was there has gone. It is tried again each second.",
     "Look at the sender, and at the address."},
    {"B080", "filter broken", "The estimate or covariance is not finite, not positive or beyond bounds.",
     "Look at the step and block that the message names; noise of zero and wild initial values are usual "
     "causes."},
    {"B081", "filter never started", "Some block never got its initial value.",
     "Look at the channel that the message names, its `max_age` and the window of the data. An alignment emits once "
     "it has "
     "had its rest, and its course."},
    {"B082", "snapshot of something else",
     "The bytes are no snapshot, or a damaged one, or one of another composition, another build of a plugin, or "
     "another "
     "version.",
     "Restore it with the config, plugins and program it was taken with. A damaged one is of no use."},
    {"B083", "a model's note",
     "A model met something in the run that people should know, or a sample that is invalid. Equal notes of one "
     "component "
     "are one warning, at once, and at the end with the time of the first and their number.",
     "Read the message; the plugin's README says more."},
    {"B084", "checkpoint of something else",
     "The file is no checkpoint, or a torn or damaged one, or one of another config, other data, options, plugins, "
     "version or "
     "kind of "
     "machine.",
     "Resume with what the run began with, or let it begin anew."},
    {"B090", "unknown variant", "--variant or a table names a variant that the study does not have.",
     "Use one of the names that the message lists; a cell without a variant is \"\"."},
    {"B091", "variants of one name", "Two variants of a study have the same name, or one that would be lost.",
     "Rename one of them; those made of dimensions are named \"A B\" after a choice of each."},
    {"B092", "journal of another study",
     "The folder given with --out holds the journal of a study with another config, seed, program or plugin.",
     "Give another folder, or delete the journal to begin anew."},
    {"B093", "a run of a study broke", "One of the runs could not be finished; the others went on without it.",
     "Repeat it alone with the command that the message gives; its summary says more."},
    {"B094", "adaptive noise in a covariance analysis",
     "A noise estimator learns from residuals, and covariances alone have none.",
     "Take the `noise` out of the measurement in what is analysed, or run a study."},
    {"B100", "locked out",
     "A measurement, or a row or key that its gate tests, was refused several times in a row and still was at the end. "
     "The "
     "filter is `lost` when it is the measurement or most of its rows; when others pass it is `doubtful`.",
     "Either the estimate is wrong (look at the start, at holes and at other reasons) or the measurement: its clock, "
     "axes, "
     "units, lever arm or standard deviations."},
    {"B101", "never accepted", "Samples of a measurement came, and the filter refused each of them.",
     "Look at `last_reason` in the summary: standard deviations of 0, units, axes, or a start far from the truth."},
    {"B102", "mostly refused", "The gate refused more than half of a measurement's rows.",
     "Compare the innovations' RMS in the summary with 1: standard deviations may be too small by that much; or the "
     "estimate is wrong."},
    {"B103", "innovations larger than their noise",
     "Over a window of at least 50 samples and 10 s the mean of NIS over its rows is more than noise as specified can "
     "make "
     "it. `lost` when the newest window is beyond all reason.",
     "The summary gives for each row the standard deviation that would fit. A wrong model, lever arm or clock makes "
     "innovations grow with motion."},
    {"B104", "biased innovations",
     "Over a window the mean of a row's innovations is further from zero than noise can make it.",
     "Something constant is not modelled: a bias, a lever arm, a mounting angle, a clock offset at constant speed, a "
     "receiver that is off."},
    {"B105", "correlated innovations",
     "Over a window a row's innovations depend on those before them more than white noise can.",
     "The measurement's errors are correlated in time (a receiver's own filter, multipath), or the process noise is "
     "too "
     "small."},
    {"B106", "recovered", "A measurement was locked out, and the covariance was opened until it passed again.",
     "Look at what came before: the estimates from the first refusal to the recovery are wrong."},
    {"B107", "locked out for a while",
     "A measurement, or a row or key, was refused several times in a row, and passes again.",
     "Look at the time that the message names: a receiver that jumps, freezes or is spoofed, or an estimate that was "
     "wrong for a while."},
    {"B108", "hole in the input", "The driving input had a hole that the filter bridged.",
     "Look for lost data. The estimates after it are as good as the rates before and after it allow."},
    {"B109", "frozen input",
     "The driving input repeated its numbers to the bit, after it had changed from sample to sample.",
     "Look at the sensor and its logger: one that hangs gives its last sample again and again."},
    {"B110", "unaided", "The filter has measurements, and no sample of any of them was used.",
     "Look at the outcomes in the summary, and at the spans of time of the channels."},
    {"B111", "implausible number", "The number is decades away from what such a sensor or vehicle has.",
     "Write the unit that is meant: \"0.3 deg/sqrt(h)\"; a number without unit is SI."},
    {"B112", "no aiding of position", "A block of lengths integrates one of velocities, and no measurement sees it.",
     "Add a measurement of the position. Dead reckoning is legal: then its error grows with time or distance."},
    {"B113", "gate without recovery", "A measurement has a gate and `\"recover\": false`.",
     "Delete `recover`; where refusals are expected, as of a zero-velocity update whose gate tests the detector, add "
     "the "
     "measurement to `except` of the filter's `trust`."},
    {"B114", "no time in common",
     "The samples of a measurement or reference, none of which was used, have no time in common with the filter's "
     "driving "
     "input. Known in a run only: `check` reads no rows.",
     "Compare the spans in the message: `offset` and `unit` of a source's `time`; GPS time is ahead of UTC by the leap "
     "seconds."},
    {"B115", "started anew",
     "Recovery was in vain several times in a row, or a hole was too long to bridge: the filter started anew.",
     "Look at what led to it: the reasons before it, the time that the message names."},
    {"B116", "stopped",
     "The driving input had a hole longer than `longest_bridge`, and no initial values came after it.",
     "Look for lost data; give the blocks an `\"again\"` from a channel that comes in motion too."},
    {"B117", "silent measurement",
     "For long no sample of a measurement was of use, and what it sees became much less certain.",
     "Look for the outage in the data; what was estimated meanwhile has the sigma that the filter gives, if its models "
     "hold."},
    {"B118", "input ended",
     "The driving input ended, or had no complete sample any more, long before the newest sample.",
     "Look for lost data, or NaN, at the end; the estimates end with the input."},
    {"B119", "likely cause: a clock",
     "A filter is not `ok`, and the velocities of a measurement fit the inertial input far better when they are "
     "shifted "
     "in time.",
     "Compare how the two are labelled: leap seconds, `offset` and `unit` of a source's `time`, the delay of the "
     "receiver. Which of the two clocks is off the data do not show."},
    {"B120", "likely cause: axes, signs or scales",
     "A filter is not `ok`, and fields of a channel contradict each other, or the inertial input, in a way that a "
     "swapped "
     "field, a wrong sign or a wrong unit explains.",
     "Compare the fields that the message names with the sensor's manual: order, axes, signs, units."},
    {"B121", "nothing to evaluate",
     "A span of `evaluate` has no sample of a reference in it, though there are some elsewhere.",
     "Compare `after`, `until` and the windows with the time that the filter ran; `\"start+60 s\"` counts from its "
     "start, other "
     "times are those of the data."},
    {"B122", "later than any history",
     "Samples of a channel came later than the longest `history` of the config's filters, so they were not used.",
     "Make `history` longer than the largest delay, or find out what holds these samples up."},
    {"B123", "live estimates lag",
     "With the budget of `history`, the steps that one arrival may cost, live estimates fell behind by more than the "
     "history, so late samples were refused until they had caught up.",
     "Allow more `steps`, or find out why so many samples come late; without `steps` there is no bound."},
    {"B124", "a latency that is no time",
     "The field that `latency` names was NaN, infinite or negative, so the sample arrived at its own time.",
     "Look at the field: is its unit a time, and is it set in each sample?"},
    {"B125", "no segment",
     "A metric of segments has no value: no reference gives position and attitude at one and the same time, or the "
     "path "
     "is shorter than the shortest segment.",
     "Let one channel be the reference of both blocks; take shorter `lengths` in `segments` of `evaluate`."},
    {"B126", "P is no covariance",
     "P of the filter has a correlation beyond one, or gives a combination of components a negative variance, by more "
     "than "
     "1e-6 of a component's own; `lost` beyond 1e-3. It is looked at every 1024 steps and before a verdict.",
     "A covariance that it started from may be none. Else digits were lost: `\"covariance\": \"ud\"` or "
     "`\"square_root\"` "
     "cannot become so by rounding."},
    {"B127", "more than P has digits for",
     "A measurement saw 1e15 times the variance of its own noise, or more. P as `joseph` keeps it has no digits for "
     "both, so "
     "sigmas after the update are zero or wrong.",
     "Set `\"covariance\"` of the filter to `\"ud\"` or `\"square_root\"`, which hold it; or give a sigma at the start "
     "that is nearer to what is known."},
    {"B128", "innovations smaller than their noise",
     "The mean NIS of a measurement over a run is less than half of what is expected. The verdict stays as it is, "
     "since sigmas that are too large take accuracy, and claim none.",
     "Reduce the standard deviations, or the process noise, as the note says. Errors that persist, as those of a "
     "receiver "
     "do, have small innovations too: then leave it, or model them as a state. `except` of `trust` silences the note."},
    {"B130", "adaptive noise in tuning",
     "A measurement's R is made of its innovations by a noise estimator, so it follows whatever is tuned.",
     "Delete its `noise` while tuning (`--set …/noise=null`), or tune by withheld samples or a metric."},
    {"B131", "nothing to tune by",
     "No sample was accepted, none was withheld, or nothing was scored, so the objective of `tune` has no value.",
     "Look at the outcomes in the summary of `run`; `withheld` needs a measurement with `withhold`, a metric a "
     "reference."},
    {"B143", "it comes once",
     "A smoother over the whole run needs its input a second time, and live sources, or `--input`, give it once.",
     "Use `\"smoother\": {\"type\": \"fixed_lag\", …}`, or smooth the records of a recorded run."},
    {"B144", "recorded input",
     "A file of `--input` is none that `run --record-input` made, is of another config, or ends in the middle of a "
     "line.",
     "Take the config that the input was recorded with; what is whole of a file that was cut short is run."},
    {"B145", "lines lost",
     "A receiver of live output was slower than the lines came, or not there, and its oldest lines were left out.",
     "Let it read faster, give the sink a larger `buffer` or fewer samples, or write to a file, which loses none."},
    {"B146", "nobody receives",
     "A connection of live output broke, its device vanished, the disk is full, or no receiver came.",
     "Look at the other side. A TCP connection and a serial device are tried again each second; the run goes on."},
};

}  // namespace

std::span<const CodeEntry> diagnostic_codes() { return entries; }

}  // namespace binnacle::document
