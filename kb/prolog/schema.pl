:- module(schema, [ declare_facts/1,        % +Declarations
                    fact_schema/2,          % ?Indicator, ?Meaning
                    fact_arguments/2,       % ?Indicator, ?Arguments
                    word_meaning/2          % ?Word, ?Meaning
                  ]).

/** <module> The facts that a scene may hold

They are declared once, in perception/facts/fact_schema.py, and handed over when Prolog starts. A
scene's module declares exactly these predicates, so a rule that asks for a fact which a scene
lacks fails instead of raising an error.
*/

:- use_module(library(aggregate)).
:- use_module(library(lists)).

:- dynamic fact_schema/2, fact_arguments/2, word_meaning/2.

%!  fact_schema(?Indicator, ?Meaning) is nondet.
%
%   Facts of form Indicator may be loaded, and mean Meaning.

%!  fact_arguments(?Indicator, ?Arguments) is semidet.
%
%   Arguments are Name-Kind, in order; a Kind is a unit or says what is named.

%!  word_meaning(?Word, ?Meaning) is nondet.
%
%   Meaning of a word of the model language.

%!  declare_facts(+Declarations) is det.
%
%   Declarations are declared(Name, Arguments, Meaning) of facts, and means(Word, Meaning) of words of the
%   model language; whatever was declared before is forgotten.

declare_facts(Declarations) :-
    % Every knowledge base declares the same facts, while others are being asked.
    forall(member(declared(Name, Arguments, Meaning), Declarations),
           ( length(Arguments, Arity),
             fact_schema(Name/Arity, Meaning),
             fact_arguments(Name/Arity, Arguments) )),
    aggregate_all(count, member(declared(_, _, _), Declarations), Count),
    aggregate_all(count, fact_schema(_, _), Count),
    !.
declare_facts(Declarations) :-
    retractall(fact_schema(_, _)),
    retractall(fact_arguments(_, _)),
    retractall(word_meaning(_, _)),
    forall(member(means(Word, Text), Declarations), assertz(word_meaning(Word, Text))),
    forall(member(declared(Name, Arguments, Meaning), Declarations),
           ( length(Arguments, Arity),
             assertz(fact_schema(Name/Arity, Meaning)),
             assertz(fact_arguments(Name/Arity, Arguments)) )).
