:- module(facetlog_target, [ put_clause/2,         % +Context, +Clause
                            declared/2,           % +Target, +Head
                            helper/5,             % +Context, +Key, +Args, -Head, -New
                            called/4,             % +Code, +Source, +Context, -Call
                            defined_in/3,         % +Goal, +Module, -Source
                            placed/3,             % +Goal, +Module, -Code
                            qualified_call/3,     % +Module, +Goal, -Code
                            call_in/2,            % +Module, +Goal
                            put_remembered/5,     % +Context, +Head, +Inputs, +Outputs, +Body
                            forget_remembered/1,  % +Target
                            copied/2,             % +Target, +Indicator
                            copy_noted/2,         % +Target, +Indicator
                            note/2,               % +Target, +Indicator
                            asks_all/1,           % +Context
                            asked_of_scene/2,     % +Target, ?Indicator
                            attempt/3,            % +Context, +Ball, :Goal
                            calls_interpreter/2,  % +Target, +Indicator
                            forget_code/1,        % +Target
                            code_notes/2,         % +Target, -Notes
                            note_again/2          % +Target, +Notes
                          ]).

/** <module> The module that rules are specialised into

It holds the new clauses, the facts of the scene at hand, and what was worked out of these. Context is
as in specialise.pl.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(library(occurs)).
:- use_module(facetlog_kb(schema)).
:- reexport(facetlog_kb(variables)).

:- meta_predicate attempt(+, +, 0).

:- dynamic asks/2,                      % Target, Indicator or all
           copy/3,                      % Target, Indicator, Number
           made/5,                      % Target, Key, Arity, Name, Number
           remembered/2.                % Target, Head

                 /*******************************
                 *            CLAUSES           *
                 *******************************/

%!  declared(+Target, +Head) is det.
%
%   Head may be called before it has clauses.

declared(Target, Head) :-
    functor(Head, Name, Arity),
    dynamic(Target:Name/Arity).

%!  called(+Code, +Source, +Context, -Call) is det.
%
%   Call does what Code does, and is a call of one predicate: what a predicate such as findall/3 is
%   given with control in it would be compiled each time. Source has all variables of Code that others
%   see.

called(Code, Source, Context, Call) :-
    (   control(Code)
    ->  term_variables(Code, All),
        term_variables(Source, Seen),
        include(among(Seen), All, Variables),
        helper(Context, goal(Code), Variables, Call, New),
        ( New == true -> put_clause(Context, (Call :- Code)) ; true )
    ;   Call = Code
    ).

control((_, _)).
control((_ ; _)).
control((_ -> _)).
control((_ *-> _)).
control(\+ _).

%!  defined_in(+Goal, +Module, -Source) is det.
%
%   The module whose predicate Goal calls in Module.

defined_in(Goal, Module, Source) :-
    (   predicate_property(Module:Goal, imported_from(Source0))
    ->  Source = Source0
    ;   Source = Module
    ).

%!  placed(+Goal, +Module, -Code) is det.
%
%   Code calls in any module what Goal calls in Module.

placed(Goal, Module, Code) :-
    defined_in(Goal, Module, Source),
    ( Source == system -> Code = Goal ; qualified_call(Source, Goal, Code) ).

%!  qualified_call(+Module, +Goal, -Code) is det.
%
%   Code calls Goal in Module. No clause may name a module that goes, as those of users' rules do.

qualified_call(Module, Goal, Code) :-
    (   module_property(Module, class(temporary))
    ->  Code = facetlog_target:call_in(Module, Goal)
    ;   Code = Module:Goal
    ).

%!  call_in(+Module, +Goal) is nondet.

call_in(Module, Goal) :-
    call(Module:Goal).

%!  put_clause(+Context, +Clause) is det.

put_clause(context(_, Target, _), Clause) :-
    assertz(Target:Clause).

%!  helper(+Context, +Key, +Args, -Head, -New) is det.
%
%   Head is a predicate of the target with these Args for what Key stands for; New is true if it was
%   made just now, and has no clause yet.

helper(context(_, Target, _), Key, Args, Head, New) :-
    length(Args, Arity),
    (   made(Target, Key0, Arity, Name, _),
        Key0 =@= Key
    ->  New = false
    ;   flag(facetlog_code, Number, Number + 1),
        functor(Key, Kind, _),
        atomic_list_concat([Kind, Number], '#', Name),
        assertz(made(Target, Key, Arity, Name, Number)),
        New = true
    ),
    Head =.. [Name|Args].

%!  attempt(+Context, +Ball, :Goal) is semidet.
%
%   Goal, once; fails if it throws Ball. Predicates that were begun then, and lack clauses, are forgotten:
%   who needs one later begins it again.

attempt(context(_, Target, _), Ball, Goal) :-
    flag(facetlog_code, Number, Number),
    catch(Goal, Ball, ( forget_since(Target, Number), fail )),
    !.

forget_since(Target, Least) :-
    forall(( made(Target, Key, Arity, Name, Number), Number >= Least ),
           retract(made(Target, Key, Arity, Name, Number))),
    forall(( copy(Target, Indicator, Number), Number >= Least ),
           retract(copy(Target, Indicator, Number))).

%!  put_remembered(+Context, +Head, +Inputs, +Outputs, +Body) is det.
%
%   Head, whose arguments are Inputs and Outputs, is what Body makes of it; for the Inputs of the scene
%   that is worked out once.

put_remembered(Context, Head, Inputs, Outputs, Body) :-
    Context = context(_, Target, _),
    Head =.. [Name|_],
    atom_concat(Name, ' known', Known),
    Answer =.. [answer|Outputs],
    append(Inputs, [Found], KnownArgs),
    Kept =.. [Known|KnownArgs],
    declared(Target, Kept),
    assertz(remembered(Target, Kept)),
    maplist(bound_test, Inputs, Tests),
    foldl(joined, Tests, true, Bound),
    put_clause(Context, (Head :- Bound, Kept, !, Found = Answer)),
    put_clause(Context,
               (Head :- ( Body -> Found = Answer ; Found = none ),
                        assertz(Target:Kept),
                        Found = Answer)).

bound_test(Input, nonvar(Input)).

joined(Goal, Before, ( Before, Goal )).

%!  forget_remembered(+Target) is det.
%
%   For the next scene.

forget_remembered(Target) :-
    forall(remembered(Target, Kept), retractall(Target:Kept)).

%!  calls_interpreter(+Target, +Indicator) is semidet.
%
%   The predicate, or one of the target that it calls, leaves something to the modules that judge any test.

calls_interpreter(Target, Indicator) :-
    reached(Target, [Indicator], [], Goals),
    member(Module:Goal, Goals),
    interpreting(Module, Goal),
    !.

interpreting(facetlog_say, said(_, _, _, _)).
interpreting(facetlog_search, outlines(_, _, _, _, _, _)).
interpreting(facetlog_quantities, value(_, _, _)).
interpreting(facetlog_quantities, value(_, _, _, _)).
interpreting(facetlog_quantities, longest_first_in(_, _, _)).
interpreting(measures, measure(_, _, _, _)).

%   Goals are those of other modules that the clauses of the predicates hold.
reached(_, [], _, []).
reached(Target, [Indicator|Next], Seen, Goals) :-
    (   memberchk(Indicator, Seen)
    ->  reached(Target, Next, Seen, Goals)
    ;   Indicator = Name/Arity,
        functor(Head, Name, Arity),
        findall(Body, clause(Target:Head, Body), Bodies),
        findall(Other,
                ( sub_term(Goal, Bodies),
                  callable(Goal),
                  functor(Goal, OtherName, OtherArity),
                  Other = OtherName/OtherArity,
                  of_target(Target, Other) ),
                Called),
        findall(Module:Goal, ( sub_term(Of, Bodies), nonvar(Of), Of = Module:Goal ), Goals, Others),
        append(Called, Next, All),
        reached(Target, All, [Indicator|Seen], Others)
    ).

of_target(Target, Indicator) :- copied(Target, Indicator).
of_target(Target, Name/Arity) :- made(Target, _, Arity, Name, _).

%!  forget_code(+Target) is det.

forget_code(Target) :-
    retractall(asks(Target, _)),
    retractall(copy(Target, _, _)),
    retractall(made(Target, _, _, _, _)),
    retractall(remembered(Target, _)).

                 /*******************************
                 *           THE NOTES          *
                 *******************************/

%!  code_notes(+Target, -Notes) is det.
%!  note_again(+Target, +Notes) is det.
%
%   Notes are all that is noted of the clauses of a target: enough to use them, not to add others.

code_notes(Target, Notes) :-
    findall(Note, code_note(Target, Note), Notes).

code_note(Target, asks(What)) :- asks(Target, What).
code_note(Target, copy(Indicator)) :- copy(Target, Indicator, _).
code_note(Target, made(Name/Arity)) :- made(Target, _, Arity, Name, _).
code_note(Target, remembered(Name/Arity)) :-
    remembered(Target, Kept),
    functor(Kept, Name, Arity).

note_again(Target, Notes) :-
    forall(member(Note, Notes), again(Note, Target)).

again(asks(What), Target) :- note(Target, What).
again(copy(Indicator), Target) :- assertz(copy(Target, Indicator, 0)).
again(made(Name/Arity), Target) :- assertz(made(Target, saved, Arity, Name, 0)).
again(remembered(Name/Arity), Target) :-
    functor(Kept, Name, Arity),
    assertz(remembered(Target, Kept)).

%!  copied(+Target, +Indicator) is semidet.
%!  copy_noted(+Target, +Indicator) is det.
%
%   Which predicates of others were copied.

copied(Target, Indicator) :-
    copy(Target, Indicator, _).

copy_noted(Target, Indicator) :-
    flag(facetlog_code, Number, Number + 1),
    assertz(copy(Target, Indicator, Number)).

%!  note(+Target, +Indicator) is det.
%
%   A fact is asked for; `all` stands for any.

note(Target, What) :-
    ( asks(Target, What) -> true ; assertz(asks(Target, What)) ).

%!  asks_all(+Context) is det.
%
%   Any fact may be asked for.

asks_all(context(_, Target, _)) :-
    note(Target, all).

%!  asked_of_scene(+Target, ?Indicator) is nondet.
%
%   The facts that Target asks for.

asked_of_scene(Target, Indicator) :-
    (   asks(Target, all)
    ->  fact_schema(Indicator, _)
    ;   asks(Target, Indicator)
    ).
