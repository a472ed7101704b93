/*  Changes of clauses, one at a time, and a program with one of them (mutants.py).

    Reads from standard input

        changes(File).          % all changes of a file
        mutant(File, Text).     % the program with Text in the place of File

    and writes for the first a list of [Line, Start, End, New, Predicate]: what stands from Start to End
    (characters) is New in the mutant. The second is a process of its own, forked with the program
    loaded, that writes its number and then reads

        case(...).              % as judging.pl, which answers it
        units.                  % writes whether all unit tests pass that were loaded

    until it is killed; then "ended" is written. What needs far more steps than the program itself
    counts as an error: a mutant may never end.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(library(unix)).
:- use_module(library(readutil)).
:- use_module(library(plunit)).
:- use_module(library(http/json)).

serve_mutants :-
    set_prolog_gc_thread(false),        % a process of several threads cannot be forked
    repeat,
    catch(read_term(user_input, Term, []), _, fail),
    (   Term == end_of_file
    ->  halt
    ;   serve(Term),
        fail
    ).

serve(changes(File)) :-
    findall(Change, change(File, Change), Changes),
    reply(Changes).
serve(mutant(File, Text)) :-
    flush_output,
    fork(Pid),
    (   Pid == child
    ->  become(File, Text)
    ;   wait(Pid, _),
        reply(ended)
    ).

reply(Answer) :-
    catch(with_output_to(string(Line), json_write_dict(current_output, Answer, [width(0)])), Error,
          format(string(Line), "~q", [Error])),   % a mutant's answer may be anything
    format("~w~n", [Line]),
    flush_output.

become(File, Text) :-
    current_prolog_flag(pid, Pid),
    setup_call_cleanup(
        open_string(Text, Stream),
        catch(load_files(File, [stream(Stream), silent(true)]), _, true),
        close(Stream)),
    reply(Pid),
    repeat,
    read_term(user_input, Term, []),
    (   Term == end_of_file
    ->  halt
    ;   catch(bounded(Term, Answer), Error, ( term_string(Error, Text1), Answer = Text1 ))
    ->  reply(Answer),
        fail
    ;   reply(failed),
        fail
    ).

%   inferences(-Number): ten times what the costliest case needs, or all unit tests.
inferences(20_000_000).

bounded(Term, Answer) :-
    inferences(Most),
    call_with_inference_limit(answer(Term, Answer0), Most, Result),
    ( Result == inference_limit_exceeded -> Answer = false ; Answer = Answer0 ).

answer(case(Facts, Files, Crisp, Tests, Pairs, Models), Answers) :-
    answers(Facts, Files, Crisp, Tests, Pairs, Models, Answers).
answer(units, Pass) :-
    statistics(warnings, Before),       % a choice that a test leaves is one
    (   run_tests,
        statistics(warnings, Before)
    ->  Pass = true
    ;   Pass = false
    ).

                 /*******************************
                 *            CHANGES           *
                 *******************************/

%   change(+File, -Change): nondet, but for directives.
change(File, [Line, Start, End, New, Predicate]) :-
    read_file_to_string(File, Text, []),
    clause_of(Text, Term, Position),
    head_of(Term, Head),
    functor(Head, Name, Arity),
    atomic_list_concat([Name, /, Arity], Predicate),
    change_of(Term, Position, Text, Start-End, New),
    sub_string(Text, 0, Start, _, Before),
    split_string(Before, "\n", "", Lines),
    length(Lines, Line).

clause_of(Text, Term, Position) :-
    setup_call_cleanup(
        open_string(Text, Stream),
        ( repeat,
          read_term(Stream, Term0, [subterm_positions(Position0)]),
          (   Term0 == end_of_file
          ->  !, fail
          ;   Term = Term0, Position = Position0
          ) ),
        close(Stream)).

head_of((:- _), _) :- !, fail.
head_of((Head :- _), Head) :- !.
head_of(Head, Head).

%   The clause is left out.
change_of(_, Position, _, Start-End, "") :-
    span(Position, Start, Last),
    End is Last + 1.
change_of((_ :- Body), term_position(_, _, _, _, [_, Position]), Text, Span, New) :-
    goal_change(Body, Position, Text, step, Span, New).
change_of(Term, Position, Text, Span, New) :-
    part_of(Term, Position, Part, At),
    \+ pair(Term, Position, Part, At),
    token_change(Part, At, Text, Span, New).

%   A minus in a body that subtracts nothing: another sign would hold the two together as well.
pair((_ :- Body), term_position(_, _, _, _, [_, Position]), _-_, At) :-
    arg(1, At, Start),
    arg(1, Position, First),
    Start >= First,
    \+ ( part_of(Body, Position, Goal, Place), calculates(Goal), part_of(Goal, Place, _, At0), At0 == At ).

calculates(_ is _).
calculates(_ < _).      calculates(_ > _).      calculates(_ =< _).     calculates(_ >= _).
calculates(_ =:= _).    calculates(_ =\= _).

span(Position, Start, End) :-
    (   Position = Start-End
    ->  true
    ;   arg(1, Position, Start),
        arg(2, Position, End)
    ).

text_at(Text, Position, Part) :-
    span(Position, Start, End),
    Length is End - Start,
    sub_string(Text, Start, Length, _, Part).

%   Goals: goal_change(Goal, Position, Text, Place, Span, New); Place is `guard` in the condition of a
%   branch.
goal_change(Goal, parentheses_term_position(_, _, Position), Text, Place, Span, New) :-
    !,
    goal_change(Goal, Position, Text, Place, Span, New).
goal_change(Goal, term_position(_, _, _, _, Positions), Text, Place0, Span, New) :-
    inner(Goal, Place0, Inner),
    !,
    member(Number-Place, Inner),
    arg(Number, Goal, One),
    nth1(Number, Positions, At),
    goal_change(One, At, Text, Place, Span, New).
goal_change(Goal, Position, Text, Place, Start-End, New) :-
    span(Position, Start, End),
    (   Goal \== true,
        New = "true"
    ;   Place == guard,
        \+ compares(Goal),
        text_at(Text, Position, Old),
        string_concat("\\+ ", Old, New)
    ).
goal_change(Goal, Position, Text, _, Start-End, New) :-
    compound(Goal),
    Position = term_position(From, _, From, _, Positions),  % no operator
    findall(A-B, ( append(_, [A, B|_], Positions), differ(Text, A, B) ), Pairs),
    Pairs = [First|_],
    last(Pairs, Last),
    sort([First, Last], Chosen),
    member(A-B, Chosen),
    span(A, Start, Middle1),
    span(B, Middle2, End),
    Length is Middle2 - Middle1,
    sub_string(Text, Middle1, Length, _, Between),
    text_at(Text, A, OldA),
    text_at(Text, B, OldB),
    atomics_to_string([OldB, Between, OldA], New).

inner((_, _), Place, [1-Place, 2-Place]).
inner((_ ; _), Place, [1-Place, 2-Place]).
inner((_ -> _), Place, [1-guard, 2-Place]).
inner(\+ _, _, [1-guard]).
inner(once(_), Place, [1-Place]).
inner(findall(_, _, _), _, [2-step]).
inner(forall(_, _), _, [1-step, 2-step]).

compares(Goal) :-
    compound(Goal),
    compound_name_arity(Goal, Name, 2),
    replaced(Name, _).

differ(Text, A, B) :-
    text_at(Text, A, One),
    text_at(Text, B, Two),
    One \== Two.

%   All parts of a term, with where they stand.
part_of(Term, Position, Term, Position).
part_of(Term, parentheses_term_position(_, _, Position), Part, At) :-
    !,
    inner_part(Term, Position, Part, At).
part_of(Term, Position, Part, At) :-
    inner_part(Term, Position, Part, At).

inner_part(Term, parentheses_term_position(_, _, Position), Part, At) :-
    part_of(Term, Position, Part, At).
inner_part(Term, term_position(_, _, _, _, Positions), Part, At) :-
    nth1(Number, Positions, Position),
    arg(Number, Term, Arg),
    part_of(Arg, Position, Part, At).
inner_part(Term, list_position(_, _, Positions, Tail), Part, At) :-
    (   nth1(Number, Positions, Position),
        length(Before, Number),
        append(Before, _, Term),
        last(Before, Arg),
        part_of(Arg, Position, Part, At)
    ;   Tail \== none,
        same_length(Positions, Firsts),
        append(Firsts, Rest, Term),
        part_of(Rest, Tail, Part, At)
    ).

token_change(Part, Start-End, Text, Start-End, New) :-
    (   number(Part)
    ->  other_number(Part, Other),
        number_string(Other, New0),
        New = New0
    ;   atom(Part),
        text_at(Text, Start-End, Old),
        atom_string(Part, Old),
        replaced_word(Part, New)
    ).
token_change(Part, term_position(_, _, Start, End, _), Text, Start-End, New) :-
    compound(Part),
    compound_name_arity(Part, Name, 2),
    text_at(Text, Start-End, Old),
    atom_string(Name, Old),
    replaced(Name, New).

%   Whatever is as good as nothing may be twice that.
other_number(Number, Other) :-
    (   integer(Number)
    ->  Other is Number + 1
    ;   Number =:= 0
    ->  Other = 1.0
    ;   abs(Number) < 1.0e-3
    ->  Other is 1.0e6*Number
    ;   Other is 2*Number
    ).

replaced(+, "-").       replaced(-, "+").       replaced(*, "/").       replaced(/, "*").
replaced(<, ">=").      replaced(>=, "<").      replaced(>, "=<").      replaced(=<, ">").
replaced(==, "\\==").   replaced(\==, "==").    replaced(=:=, "=\\=").  replaced(=\=, "=:=").
replaced(=@=, "\\=@="). replaced(max, "min").   replaced(min, "max").

replaced_word(holds, "fails").      replaced_word(fails, "unknown").
replaced_word(unknown, "holds").    replaced_word(below, "above").
replaced_word(above, "below").      replaced_word(state, "full").
replaced_word(full, "state").       replaced_word(true, "false").
replaced_word(false, "true").
