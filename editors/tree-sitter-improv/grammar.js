// Improv for tree-sitter: the rules of improv_core/syntax/grammar.lark, with the words from words.json.
// src/scanner.c decides where a statement ends, which line ends are only white space, and which names are parameters
// or words of the opening.

/// <reference types="tree-sitter-cli/dsl" />

const words = require("./words.json");

// Each of our signs, or what stands for it on other keyboards.
const either = (ours, ...others) => choice(ours, ...others.map((other) => alias(other, ours)));
const [EQUALS, DOLLAR, BARS] = [either("=", "＝"), either("$", "＄"), either("||", "｜｜")];
const [TIMES, DIVIDED] = [either("*", "×", "＊"), either("/", "÷", "⁄", "／")];
const NAME = "[\\p{L}\\p{Nl}\\p{No}_\uFF3F][\\p{XID_Continue}\\p{N}\u200C\u200D]*";

module.exports = grammar({
  name: "improv",

  externals: ($) => [
    $._end,
    $._line_break,
    "(",
    ")",
    "[",
    "]",
    $._defined,
    $._number_parameter,
    $._movement_parameter,
    $._at,
    $._is,
    $._room,
    $._bar,
  ],
  extras: ($) => [/[ \t\uFEFF\u00AD\u200B\u2060-\u2064\p{Zs}]/, $._line_break, $.comment],
  word: ($) => $.name,

  rules: {
    document: ($) => seq(repeat(seq(optional($._statement), $._end)), optional($._statement)),
    _statement: ($) =>
      choice($.tempo, $.definition, $.play, $.scene, $.placing, $.kind, $.room, $.bar, $.unfinished),

    tempo: ($) => seq(alias(choice(...words.beat), $.beat), $.number),
    definition: ($) =>
      seq(
        field("name", alias($._defined, $.name)),
        repeat(field("parameter", $._parameter)),
        repeat(seq("(", field("parameter", $._parameter), ")")),
        EQUALS,
        field("movement", $._movement),
      ),
    _parameter: ($) => alias(choice($._number_parameter, $._movement_parameter), $.parameter),
    play: ($) => seq($._robots, DOLLAR, field("movement", $._movement)),
    scene: ($) => seq(alias(/[-\u2212\uFF0D][-\u2212\uFF0D][-\u2212\uFF0D]+/, "---"), optional(field("name", alias($.name, $.title)))),

    // The words of these lines are names everywhere else, so only the scanner knows which is which.
    placing: ($) => seq($._robots, alias($._at, "at"), choice($._point, $._circle, $._rows)),
    _point: ($) => seq($._length, $._length, optional(seq("facing", $._length))),
    _circle: ($) =>
      seq(
        alias("circle", $.formation),
        $._length,
        optional(choice(seq($._facing, optional($._around)), seq($._around, optional($._facing)))),
      ),
    _rows: ($) => seq(alias(choice("line", "grid"), $.formation), $._length, optional($._around)),
    _facing: ($) => seq("facing", alias(choice("in", "out"), $.direction)),
    _around: ($) => seq("around", $._length, $._length),
    kind: ($) => seq($._robots, alias($._is, "is"), $.profile),
    room: ($) => seq(alias($._room, "room"), $._length, $._length),
    bar: ($) => seq(alias($._bar, "bar"), $.number),
    // `$` or `=` is still missing. Names at the start are robots, so that they keep their color when `$` follows.
    unfinished: ($) => choice($._robots, seq(optional($._robots), $._begun)),
    _robots: ($) => repeat1(alias($.name, $.robot)),
    _begun: ($) => seq(choice($._built_in, $.number), repeat($._term), repeat(seq(BARS, $._voice))),

    _movement: ($) => choice($._voice, $.parallel),
    parallel: ($) => seq($._voice, repeat1(seq(BARS, $._voice))),
    _voice: ($) => prec.right(choice($._term, $.series)),
    series: ($) => prec.right(seq($._term, repeat1($._term))),
    _term: ($) => choice($.name, $.call, alias($._movement_parameter, $.parameter), $._built_in),
    _built_in: ($) => choice($.primitive, $.measured, $.group, $.squeeze, $.transformation, $.conditional),

    // How many movements a phrase takes is known only from its definition, so they are the next items of the series.
    call: ($) => seq(field("name", choice($.name, alias($._movement_parameter, $.parameter))), repeat1($.number)),
    group: ($) => seq("(", optional($._movement), ")"),
    squeeze: ($) => seq("[", optional($._movement), "]"),
    transformation: ($) =>
      choice(
        seq(transformer($, words.plain), $._term),
        seq(transformer($, words.repeat), optional($.number), $._term),
        seq(transformer($, words.reflect), $.plane, $._term),
        seq(transformer($, words.factor), $.number, $._term),
        seq(transformer($, words.ramp), $.number, $.number, $._term),
        seq(transformer($, words.guard), $.condition, $._term),
      ),
    // Between `if` and `else` stands one term, or a phrase and its movements. While you type, `else` may be missing.
    conditional: ($) =>
      prec.right(seq(choice(...words.if), $.condition, $._voice, optional(seq(choice(...words.else), $._term)))),
    condition: ($) => seq(optional(choice(...words.not)), alias($.name, $.sense)),

    // Units and `radius` are names everywhere else.
    measured: ($) =>
      choice(
        seq($.primitive, $._length, optional(seq("radius", $._length))),
        prec(1, seq($.primitive, "radius", $._length)),
      ),
    _length: ($) => alias($.measure, $.number),
    measure: ($) => seq($._measured_factor, repeat(seq(choice(TIMES, DIVIDED), $._measured_factor))),
    _measured_factor: ($) => choice(seq($._digits, optional($._unit)), alias($._number_parameter, $.parameter)),
    _unit: () => token.immediate(choice(...words.unit)),

    primitive: () => choice(...words.primitive),
    plane: () => choice(...words.plane),
    name: () => new RegExp(NAME),
    profile: () => new RegExp(`${NAME}(-+[\\p{L}\\p{N}_]+)*`),
    number: ($) => seq($._factor, repeat(seq(choice(TIMES, DIVIDED), $._factor))),
    _factor: ($) => choice($._digits, alias($._number_parameter, $.parameter)),
    _digits: () => /[+\-\u2212\uFF0B\uFF0D]?[0-9\uFF10-\uFF19]*[.\uFF0E]?[0-9\uFF10-\uFF19]+/,
    comment: () => /[#\uFF03][^\r\n]*/,
  },
});

function transformer($, choices) {
  return alias(choice(...choices), $.transformer);
}
