:- module(facetlog_question, [ question/3        % +Text, +Bindings, -Question
                             ]).

/** <module> The text of a question into a goal

A question is one goal, as in Prolog, over the facts by name, the vocabulary, the verdicts and the
list of harmless words. Question is

    question(Goal, Names, Vars, PerScene)

Goal runs in the module facetlog_query, under in_scene/2 if PerScene is true; Names and Vars are
those of the variables that an answer can give a value.
*/

:- use_module(library(assoc)).
:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(library(occurs)).
:- use_module(facetlog_kb(reading)).
:- use_module(facetlog_kb(spelling)).
:- use_module(facetlog_kb(check)).
:- use_module(facetlog_kb(prepare)).
:- use_module(facetlog_kb(white_list)).
:- use_module(facetlog_kb(pairs)).
:- use_module(facetlog_kb(seen_parts)).
:- use_module(facetlog_kb(quantities)).
:- use_module(facetlog_kb(bounded_numbers)).
:- use_module(facetlog_kb(bounded_text)).
:- use_module(facetlog_kb(scene)).
:- use_module(facetlog_kb(python)).
:- use_module(facetlog_kb(words)).
:- use_module(facetlog_kb(named_models), [model_module/2]).
:- use_module(facetlog_kb(ask)).

%!  question(+Text, +Bindings, -Question) is det.
%
%   Bindings are Name=Value: the variable Name stands for that value.
%
%   @throws question_error(Start, End, Format, Args), offsets into Text from 0.

question(Text, Bindings, question(Runnable, Names, Vars, PerScene)) :-
    read_question(Text, Goal, Position, Named0),
    bind(Bindings, Text, Named0, Named),
    question_scope(Scope),
    name_models(Named, Goal),
    findall(Fault,
            ( goal_fault(Goal, Position, Scope, Fault)
            ; joined_fault(Goal, Position, Scope, Fault)
            ),
            Faults),
    (   Faults == []
    ->  true
    ;   first_fault(Faults, fault(Start, End, Format, Args)),
        throw(question_error(Start, End, Format, Args))
    ),
    answer_columns(Named, Goal, Scope, Names, Vars),
    ( scene_dependent(Goal, Scope) -> PerScene = true ; PerScene = false ),
    prepared(Goal, Scope, facetlog_query, Runnable).

%   The leftmost, and there the shortest.
first_fault(Faults, Fault) :-
    findall(key(Start, End)-fault(Start, End, Format, Args),
            member(fault(Start, End, Format, Args), Faults),
            Keyed),
    keysort(Keyed, [_-Fault|_]).

bind([], _, Named, Named).
bind([Name=Value|Bindings], Text, Named0, Named) :-
    (   selectchk(Name=Variable, Named0, Named1)
    ->  Variable = Value,
        bind(Bindings, Text, Named1, Named)
    ;   string_length(Text, Length),
        findall(Known, member(Known=_, Named0), Names),
        hint(Name, Names, Hint),
        throw(question_error(0, Length, "the question has no variable ~w~w", [Name, Hint]))
    ).

%   Python functions are a question's own words.
question_scope(Own) :-
    (   nb_current(facetlog_base, Base-_)
    ->  findall(Indicator-own, python_predicate(Base, Indicator, _), Pairs)
    ;   Pairs = []
    ),
    sort(1, @<, Pairs, Sorted),
    ord_list_to_assoc(Sorted, Own).

%   A model may be called as a German noun is written: where a model is wanted, Tisch is that model, if
%   there is one.
name_models([], _).
name_models([Name=Variable|Named], Goal) :-
    (   var(Variable),
        model_module(Name, _),
        sub_term(Part, Goal),
        compound(Part),
        model_place(Part, Place),
        Place == Variable
    ->  Variable = Name
    ;   true
    ),
    name_models(Named, Goal).

                 /*******************************
                 *           VARIABLES          *
                 *******************************/

%   A variable is a column of the answer if its name has no _ before it and an answer can bind it.
answer_columns([], _, _, [], []).
answer_columns([Name=Variable|Named], Goal, Scope, Names, Vars) :-
    (   var(Variable),
        \+ sub_atom(Name, 0, _, _, '_'),
        gives(Goal, Scope, Variable)
    ->  Names = [Name|Names1],
        Vars = [Variable|Vars1]
    ;   Names = Names1,
        Vars = Vars1
    ),
    answer_columns(Named, Goal, Scope, Names1, Vars1).

%   Goal may bind Variable for who comes after it.
gives(each_pair(_, _, Faces, _), _, Variable) :-
    !,
    occurs(Variable, Faces).
gives(Goal, Scope, Variable) :-
    sorted_word(Goal, Scope, Head),
    !,
    compound(Head),
    arg(Index, Head, Sort),
    arg(Index, Goal, Argument),
    given_by(Sort, Argument, Goal, Scope, Variable),
    !.
gives(Goal, _, Variable) :-
    occurs(Variable, Goal).

sorted_word(Goal, Own, Head) :-
    functor(Goal, Name, Arity),
    \+ get_assoc(Name/Arity, Own, _),
    ( Goal = in(_, _) -> Head = in('Scene', goal('Goal')) ; allowed_word(Goal, Head) ).

given_by(inner(_), _, _, _, _) :- !, fail.
given_by(hidden(_), _, _, _, _) :- !, fail.
given_by(summary(_), _, _, _, _) :- !, fail.
given_by(goal(_), Goal, _, Scope, Variable) :-
    !,
    gives(Goal, Scope, Variable).
given_by(bag(_), Bag, Whole, Scope, Variable) :-
    !,
    % The variables that are neither in the template nor before ^.
    arg(1, Whole, Template),
    inner_goal(Bag, Hidden, Goal),
    \+ occurs(Variable, Template-Hidden),
    gives(Goal, Scope, Variable).
given_by(_, Argument, _, _, Variable) :-
    occurs(Variable, Argument).

occurs(Variable, Term) :-
    term_variables(Term, Variables),
    member(Other, Variables),
    Other == Variable,
    !.

                 /*******************************
                 *             SCENE            *
                 *******************************/

%!  scene_dependent(+Goal, +Scope) is semidet.
%
%   Goal has an answer for each scene: it asks a scene outside in/2.

scene_dependent(in(_, _), _) :-
    !,
    fail.
scene_dependent(Goal, Scope) :-
    sorted_word(Goal, Scope, Head),
    !,
    compound(Head),
    arg(Index, Head, Sort),
    compound(Sort),
    arg(Index, Goal, Argument),
    inside(Sort, Argument, Inner),
    scene_dependent(Inner, Scope),
    !.
scene_dependent(Goal, Own) :-
    functor(Goal, Name, Arity),
    \+ get_assoc(Name/Arity, Own, _).

inside(goal(_), Goal, Goal).
inside(inner(_), Goal, Goal).
inside(bag(_), Bag, Goal) :-
    inner_goal(Bag, _, Goal).
inside(closure(Extra, _), Closure, Goal) :-
    extended(Closure, Extra, Goal).

%   What prepared goals call.
prepared_word(Word) :-
    member(Word, [bounded_value/2, bounded_values/2, holds_in/2, possible_in/2, each_pair_in/5,
                  as_far_as_seen_in/4, longest_first_in/3, spend_on_answer/1, in/2, call_python/2]).
prepared_word(lambda/Arity) :-
    between(4, 8, Arity).
prepared_word(Bounded/Arity) :-
    bounded_text_word(_/Arity, Bounded).

:- furnish(facetlog_query).
:- forall(member(Word, [is_a/2, verdict/4, plays/4, assignment/3]),
          @(import(facetlog_ask:Word), facetlog_query)).
:- forall(( prepared_word(Name/Arity),
            functor(Head, Name, Arity),
            predicate_property(facetlog_question:Head, imported_from(Source)) ),
          @(import(Source:Name/Arity), facetlog_query)).
