:- module(facetlog_rule_module, [ new_rule_module/1,   % +Module
                                  furnish/2,           % +Kind, +Module
                                  support_word/2       % ?Kind, ?Indicator
                                ]).

/** <module> The modules that rules and questions run in

Such a module sees the list of harmless words, the vocabulary, and what prepared goals call; it
inherits from `system`, not from `user`, so that nothing else gets in.
*/

:- use_module(library(lists)).
:- use_module(facetlog_kb(white_list)).
:- use_module(facetlog_kb(scene)).
:- use_module(facetlog_kb(prepare)).
:- use_module(facetlog_kb(pairs)).
:- use_module(facetlog_kb(seen_parts)).
:- use_module(facetlog_kb(quantities)).
:- use_module(facetlog_kb(bounded_numbers)).
:- use_module(facetlog_kb(bounded_text)).
:- use_module(facetlog_kb(python)).
:- use_module(facetlog(vocabulary)).

%!  new_rule_module(+Module) is det.
%
%   Makes Module, for one file of rules, and goes without a trace when it is destroyed.

new_rule_module(Module) :-
    set_module(Module:class(temporary)),
    furnish(rules, Module).

%!  furnish(+Kind, +Module) is det.
%
%   Module sees what rules or questions (Kind) may see, and nothing else.

furnish(Kind, Module) :-
    forall(import_module(Module, Other), delete_import_module(Module, Other)),
    add_import_module(Module, system, start),
    module_property(vocabulary, exports(Words)),
    forall(member(Word, Words), @(import(vocabulary:Word), Module)),
    forall(library_word(Source:Word), @(import(Source:Word), Module)),
    forall(( support_word(Kind, Word), source(Word, Source) ), @(import(Source:Word), Module)).

source(Name/Arity, Source) :-
    functor(Head, Name, Arity),
    predicate_property(facetlog_rule_module:Head, imported_from(Source)).

%!  support_word(?Kind, ?Indicator) is nondet.
%
%   Prepared rules or questions (Kind) call it.

support_word(_, fact/1).
support_word(_, bounded_value/2).
support_word(_, bounded_values/2).
support_word(_, holds_in/2).
support_word(_, possible_in/2).
support_word(_, each_pair_in/5).
support_word(_, as_far_as_seen_in/4).
support_word(_, longest_first_in/3).
support_word(rules, measure_in/5).
support_word(_, lambda/Arity) :-
    between(4, 8, Arity).
support_word(_, spend_on_answer/1).
support_word(_, Bounded/Arity) :-
    bounded_text_word(_/Arity, Bounded).
support_word(questions, in/2).
support_word(questions, call_python/2).
