// Improv for tree-sitter: the rules of improv_core/syntax/grammar.lark, with the words from words.json.
// src/scanner.c decides where a statement ends and which line ends are only white space.

/// <reference types="tree-sitter-cli/dsl" />

const words = require("./words.json");

module.exports = grammar({
  name: "improv",

  externals: ($) => [$._end, $._line_break, "(", ")", "[", "]"],
  extras: ($) => [/[ \t\uFEFF]/, $._line_break, $.comment],
  word: ($) => $.name,

  rules: {
    document: ($) => seq(repeat(seq(optional($._statement), $._end)), optional($._statement)),
    _statement: ($) => choice($.tempo, $.definition, $.play, $.unfinished),

    tempo: ($) => seq(alias(choice(...words.beat), $.beat), $.number),
    definition: ($) => seq(field("name", $.name), "=", field("movement", $._movement)),
    play: ($) => seq($._robots, "$", field("movement", $._movement)),
    // `$` or `=` is still missing. Names at the start are robots, so that they keep their color when `$` follows.
    unfinished: ($) => choice($._robots, seq(optional($._robots), $._begun)),
    _robots: ($) => repeat1(alias($.name, $.robot)),
    _begun: ($) => seq($._built_in, repeat($._term), repeat(seq("||", $._voice))),

    _movement: ($) => choice($._voice, $.parallel),
    parallel: ($) => seq($._voice, repeat1(seq("||", $._voice))),
    _voice: ($) => choice($._term, $.series),
    series: ($) => seq($._term, repeat1($._term)),
    _term: ($) => choice($.name, $._built_in),
    _built_in: ($) => choice($.primitive, $.group, $.squeeze, $.transformation),

    group: ($) => seq("(", optional($._movement), ")"),
    squeeze: ($) => seq("[", optional($._movement), "]"),
    transformation: ($) =>
      choice(
        seq(transformer($, words.mirror), $._term),
        seq(transformer($, words.repeat), optional($.number), $._term),
        seq(transformer($, words.reflect), $.plane, $._term),
        seq(transformer($, words.factor), $.number, $._term),
      ),

    primitive: () => choice(...words.primitive),
    plane: () => choice(...words.plane),
    name: () => /[\p{L}\p{Nl}\p{No}_][\p{L}\p{N}_]*/,
    number: () => /[+-]?[0-9]*\.?[0-9]+(\/[+-]?[0-9]*\.?[0-9]+)?/,
    comment: () => /#[^\r\n]*/,
  },
});

function transformer($, choices) {
  return alias(choice(...choices), $.transformer);
}
