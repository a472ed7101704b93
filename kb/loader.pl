:- module(facetlog_loader, [ load_builtin/2,      % +Path, -Loaded
                             load_user_rules/2,   % +Path, -Loaded
                             drop_rules/1,        % +Module
                             check_query/1        % +Goal
                           ]).

/** <module> Rule files into modules

A user's file is read as data, checked, and only then added to a module of its own. Its bodies may
call what the vocabulary exports, what the file itself defines, and a list of harmless builtins:
what is not on the list is refused, so nothing has to be forbidden by name.
*/

:- use_module(library(lists)).
:- use_module(library(error)).
:- use_module(facetlog(vocabulary)).
:- use_module(facetlog(schema)).
:- use_module(facetlog_kb(judge)).

%!  load_builtin(+Path, -Loaded) is det.
%
%   Loads a model that comes with the program. Loaded is loaded(Module, Models).

load_builtin(Path, loaded(Module, Models)) :-
    load_files(Path, [if(not_loaded), imports([]), silent(true)]),
    module_property(Module, file(Path)),
    findall(Model, Module:model(Model, _, _), Models).

%!  load_user_rules(+Path, -Loaded) is det.
%
%   @throws rule_error(Path, Line, Format, Args) at the first fault.

load_user_rules(Path, loaded(Module, Models)) :-
    read_rules(Path, Clauses),
    findall(Name/Arity, ( member(rule(Clause, _), Clauses), head_of(Clause, Name/Arity) ), Own0),
    sort(Own0, Own),
    findall(Word, ( member(rule(Clause, _), Clauses), means_head(Clause, Word) ), Words),
    forall(member(rule(Clause, Line), Clauses),
           ( check_clause(Clause, Own, Path, Line),
             check_tests(Clause, Words, Path, Line) )),
    check_protocol(Clauses, Own, Path),
    gensym('facetlog_rules:', Module),
    set_module(Module:class(temporary)),
    forall(import_module(Module, Other), delete_import_module(Module, Other)),
    add_import_module(Module, system, start),
    use_vocabulary(Module),
    forall(member(rule(Clause, _), Clauses), assertz(Module:Clause)),
    findall(Model, Module:model(Model, _, _), Models).

use_vocabulary(Module) :-
    forall(member(File, [facetlog(vocabulary), library(lists), library(apply), library(aggregate),
                        library(solution_sequences)]),
           @(use_module(File), Module)),
    @(use_module(facetlog_kb(scene), [fact/1]), Module).

%!  drop_rules(+Module) is det.

drop_rules(Module) :-
    '$destroy_module'(Module).

                 /*******************************
                 *            READING           *
                 *******************************/

read_rules(Path, Clauses) :-
    setup_call_cleanup(
        catch(open(Path, read, Stream, [encoding(utf8)]), error(Why, _),
              ( unreadable(Why, What), throw(rule_error(Path, 0, What, [])) )),
        read_clauses(Stream, Path, Clauses),
        close(Stream)).

unreadable(existence_error(_, _), "there is no such file") :- !.
unreadable(permission_error(_, _, _), "it may not be read") :- !.
unreadable(_, "it cannot be read").

read_clauses(Stream, Path, Clauses) :-
    catch(read_term(Stream, Term, [module(facetlog_reading), term_position(Position),
                                   syntax_errors(error)]),
          error(syntax_error(Why), Where),
          syntax_fault(Path, Why, Where)),
    (   Term == end_of_file
    ->  Clauses = []
    ;   stream_position_data(line_count, Position, Line),
        (   Term = (:- Directive)
        ->  check_directive(Directive, Path, Line),
            Clauses = Rest
        ;   Clauses = [rule(Term, Line)|Rest]
        ),
        read_clauses(Stream, Path, Rest)
    ).

syntax_fault(Path, Why, Where) :-
    (   Where = stream(_, Line, _, _) ; Where = file(_, Line, _, _) ; Line = 0 ),
    !,
    (   '$messages':syntax_error(Why, Parts, [])
    ->  with_output_to(string(What0), print_message_lines(current_output, '', Parts)),
        normalize_space(string(What), What0)
    ;   format(string(What), "~w", [Why])
    ),
    throw(rule_error(Path, Line, "syntax error: ~w", [What])).

check_directive(module(_, _), _, _) :- !.
check_directive(use_module(facetlog(vocabulary)), _, _) :- !.
check_directive(use_module(library(solution_sequences)), _, _) :- !.
check_directive(Directive, Path, Line) :-
    throw(rule_error(Path, Line,
                     "the directive ~q is refused: only module/2 and use_module(facetlog(vocabulary)) are read",
                     [Directive])).

                 /*******************************
                 *           CHECKING           *
                 *******************************/

head_of(Clause, Name/Arity) :-
    ( Clause = (Head :- _) -> true ; Head = Clause ),
    callable(Head),
    functor(Head, Name, Arity).

check_clause(Clause, Own, Path, Line) :-
    (   head_of(Clause, Head),
        Head = Name/Arity,
        \+ memberchk(Name/Arity, [(:)/2, (-->)/2, (?-)/1])
    ->  true
    ;   throw(rule_error(Path, Line, "this is no rule: ~q", [Clause]))
    ),
    (   vocabulary_word(Head)
    ->  throw(rule_error(Path, Line, "~q is a word of the vocabulary and cannot be defined anew", [Head]))
    ;   functor(General, Name, Arity),
        ( harmless(Head) ; predicate_property(system:General, built_in) )
    ->  throw(rule_error(Path, Line, "~q is Prolog's own and cannot be defined anew", [Head]))
    ;   true
    ),
    (   Clause = (_ :- Body)
    ->  check_body(Body, Own, Path, Line)
    ;   true
    ).

vocabulary_word(Indicator) :-
    module_property(vocabulary, exports(Words)),
    memberchk(Indicator, Words).

check_body(Goal, _, Path, Line) :-
    var(Goal),
    !,
    throw(rule_error(Path, Line, "a variable stands where a goal is wanted", [])).
check_body(Goal, Own, Path, Line) :-
    callable(Goal),
    functor(Goal, Name, Arity),
    (   control(Goal, Subgoals)
    ->  forall(member(G, Subgoals), check_body(G, Own, Path, Line))
    ;   memberchk(Name/Arity, Own)
    ->  true
    ;   vocabulary_word(Name/Arity)
    ->  true
    ;   harmless(Name/Arity)
    ->  true
    ;   closure(Goal, Closure, Extra)
    ->  check_closure(Closure, Extra, Own, Path, Line)
    ;   throw(rule_error(Path, Line, "~q is not a word of the vocabulary, and this file does not define it",
                         [Name/Arity]))
    ),
    !.
check_body(Goal, _, Path, Line) :-
    throw(rule_error(Path, Line, "~q is no goal", [Goal])).

check_closure(Closure, _, _, Path, Line) :-
    var(Closure),
    !,
    throw(rule_error(Path, Line, "a variable stands where a goal is wanted", [])).
check_closure(Closure, Extra, Own, Path, Line) :-
    callable(Closure),
    Closure =.. [Name|Args],
    length(Blanks, Extra),
    append(Args, Blanks, All),
    Goal =.. [Name|All],
    check_body(Goal, Own, Path, Line).

%   The argument of fact/1 must be seen to be a fact: what is none might act.
control(fact(Fact), []) :-
    callable(Fact),
    functor(Fact, Name, Arity),
    fact_schema(Name/Arity, _).
control((A, B), [A, B]).
control((A ; B), [A, B]).
control((A -> B), [A, B]).
control(\+ A, [A]).
control(once(A), [A]).
control(limit(_, A), [A]).
control(forall(A, B), [A, B]).
control(findall(_, A, _), [A]).
control(aggregate_all(_, A, _), [A]).
control(setof(_, A, _), [G]) :- inner(A, G).
control(bagof(_, A, _), [G]) :- inner(A, G).

inner(G, G) :- var(G), !.
inner(_^A, G) :- !, inner(A, G).
inner(G, G).

closure(include(C, _, _), C, 1).
closure(exclude(C, _, _), C, 1).
closure(maplist(C, _), C, 1).
closure(maplist(C, _, _), C, 2).

%   Builtins that neither change nor reach anything outside the rule.
harmless(true/0).       harmless(fail/0).      harmless(false/0).
harmless(!/0).          harmless(= /2).        harmless(\= /2).
harmless(== /2).        harmless(\== /2).      harmless(@< /2).
harmless(@> /2).        harmless(@=< /2).      harmless(@>= /2).
harmless(is/2).         harmless(=:= /2).      harmless(=\= /2).
harmless(< /2).         harmless(> /2).        harmless(=< /2).
harmless(>= /2).        harmless(var/1).       harmless(nonvar/1).
harmless(atom/1).       harmless(number/1).    harmless(is_list/1).
harmless(ground/1).     harmless(length/2).    harmless(member/2).
harmless(memberchk/2).  harmless(append/3).    harmless(nth0/3).
harmless(nth1/3).       harmless(last/2).      harmless(reverse/2).
harmless(msort/2).      harmless(sort/2).      harmless(sort/4).
harmless(max_list/2).   harmless(min_list/2).  harmless(sum_list/2).
harmless(max_member/2). harmless(min_member/2). harmless(subtract/3).
harmless(select/3).     harmless(permutation/2). harmless(between/3).

                 /*******************************
                 *             TESTS            *
                 *******************************/

means_head(Clause, Word) :-
    ( Clause = (Head :- _) -> true ; Head = Clause ),
    nonvar(Head),
    Head = means(Word, _).

%   The tests of conditions and definitions may use only words that there are.
check_tests(Clause, Words, Path, Line) :-
    ( Clause = (Head :- _) -> true ; Head = Clause ),
    (   tested(Head, Test)
    ->  forall(unknown_word(Test, Words, Name/Arity),
               ( suggestion(Name, Words, Hint),
                 throw(rule_error(Path, Line, "~q is no word of the vocabulary or of this file~w",
                                  [Name/Arity, Hint])) ))
    ;   true
    ).

tested(condition(_, _, _, _, _, Test), Test).
tested(means(_, Test), Test).

%!  unknown_word(+Test, +Words, -Indicator) is nondet.
%
%   Indicator is what Test uses although neither the vocabulary nor Words has it. What is still a
%   variable is bound by the clause's body and checked when it is asked.

unknown_word(Test, _, _) :-
    var(Test),
    !,
    fail.
unknown_word(Test, _, Unknown) :-
    comparison(Test, Measure, Bounds),
    !,
    Bounds =.. [_|Limits],
    member(Expression, [Measure|Limits]),
    unknown_measure(Expression, Unknown).
unknown_word(Test, Words, Unknown) :-
    subtests(Test, Tests),
    !,
    member(Subtest, Tests),
    unknown_word(Subtest, Words, Unknown).
unknown_word(Test, Words, Name/Arity) :-
    callable(Test),
    functor(Test, Name, Arity),
    functor(General, Name, Arity),
    \+ known_relation(General),
    \+ derived_word(General),
    \+ memberchk(General, Words).

subtests(all(Tests), List) :- listed(Tests, List).
subtests(any(Tests), List) :- listed(Tests, List).
subtests(each(_, _, Test), [Test]).
subtests(some(_, _, Test), [Test]).
subtests(each_pair(_, _, _, Test), [Test]).
subtests(not(Test), [Test]).
subtests(if_known(Test), [Test]).
subtests(expect(_, Test), [Test]).

listed(Tests, List) :-
    ( is_list(Tests) -> List = Tests ; List = [] ).

unknown_measure(Expression, _) :-
    ( var(Expression) ; number(Expression) ; Expression = tolerance(_) ),
    !,
    fail.
unknown_measure(Expression, Unknown) :-
    Expression =.. [Operator|Args],
    memberchk(Operator, [+, -, *, /]),
    !,
    member(Arg, Args),
    unknown_measure(Arg, Unknown).
unknown_measure(Measure, Name/Arity) :-
    callable(Measure),
    functor(Measure, Name, Arity),
    functor(General, Name, Arity),
    \+ known_measure(General).

suggestion(Name, Words, Hint) :-
    (   known_name(Words, Known),
        dwim_match(Name, Known)
    ->  format(atom(Hint), "; did you mean ~w?", [Known])
    ;   Hint = ''
    ).

known_name(Words, Name) :-
    (   known_measure(Word)
    ;   known_relation(Word)
    ;   derived_word(Word)
    ;   member(Word, Words)
    ;   member(Word, [near(_, _, _), at_least(_, _), at_most(_, _), between(_, _, _), all(_),
                      any(_), each(_, _, _), some(_, _, _), each_pair(_, _, _, _), not(_),
                      expect(_, _), if_known(_)])
    ),
    functor(Word, Name, _).

%   Every model says what it looks for, among what, and by which conditions.
check_protocol(_, Own, Path) :-
    forall(member(Needed, [model/3, candidate/3, condition/6]),
           (   memberchk(Needed, Own)
           ->  true
           ;   throw(rule_error(Path, 0, "a model needs ~q; see docs/models.md", [Needed]))
           )).

%!  check_query(+Goal) is det.
%
%   A question may use the same words as a rule, and the facts.

check_query(Goal) :-
    check_body(Goal, [], "the question", 0).

:- use_vocabulary(facetlog_query).
