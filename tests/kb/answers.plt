% Chunks of solutions, columns, and floats as bytes.
:- use_module(library(plunit)).
:- use_module(facetlog_kb(answers)).
:- use_module(facetlog_kb(columns)).
:- use_module(facetlog_kb(float_bytes)).

% How many rows each chunk of the goal's solutions has.
counts(Goal, Most, Counts) :-
    findall(Count,
            ( chunk([], Goal, Most, [Header|_]),
              split_string(Header, " ", "", [Text, _]),
              number_string(Count, Text) ),
            Counts).

:- begin_tests(chunk).

test(first_is_small_then_full, Counts == [64, 4096, 840]) :-
    counts(between(1, 5000, _), inf, Counts).
test(no_solution_is_one_empty_chunk, Counts == [0]) :-
    counts(fail, inf, Counts).
test(limit_within_a_chunk, Counts == [3]) :-
    counts(repeat, 3, Counts).
test(limit_beyond_a_chunk, Counts == [64, 36]) :-
    counts(repeat, 100, Counts).
test(limit_at_the_end_of_a_chunk, Counts == [64]) :-
    counts(repeat, 64, Counts).
test(limit_of_nothing_asks_nothing, Counts == [0]) :-
    counts(throw(asked), 0, Counts).
test(slow_solutions_come_one_by_one, Counts == [1, 1, 1]) :-
    counts(( member(_, [a, b, c]), sleep(0.06) ), inf, Counts0),
    exclude(==(0), Counts0, Counts).
test(goal_that_turns_slow_is_handed_over, true(First =< 64)) :-
    chunk([], ( between(1, 1000, N), ( N > 10 -> sleep(0.01) ; true ) ), inf, [Header|_]),
    !,
    split_string(Header, " ", "", [Text, _]),
    number_string(First, Text).
test(last_chunk_leaves_no_choice, [true(Header == "2 n"), det]) :-
    chunk([X], member(X, [1, 2]), inf, [Header, _]).
test(chunks_may_stand_in_each_other, Pairs == ["1,1", "1,1", "2,2", "2,2"]) :-
    findall(Text,
            ( chunk([X], ( member(X, [1, 2]), sleep(0.06) ), inf, [_, Outer]),
              Outer \== "[]",
              chunk([Y], ( member(_, [a, b]), sleep(0.06), number_string(Y, Outer) ), inf,
                    [_, Inner]),
              Inner \== "[]",
              atomics_to_string([Outer, ',', Inner], Text) ),
            Pairs).
test(error_of_the_goal_is_an_error_of_the_chunk, error(evaluation_error(zero_divisor))) :-
    chunk([X], X is 1/0, inf, _).

:- end_tests(chunk).

:- begin_tests(columns).

test(each_column_in_its_layout, Pieces == ["2 nas", "1,2.5", "p\x1f\\x1f\"]) :-
    columns(3, [row(1, p, ""), row(2.5, '', "")], [Header, Numbers, Atoms, Strings]),
    string_length(Strings, 1),
    string_concat(Atoms, "", Atoms1),
    Pieces = [Header, Numbers, Joined],
    string_concat(Atoms1, Strings, Joined).
test(separator_inside_a_name, Header == "1 j") :-
    columns(1, [row('a\x1f\b')], [Header, _]).
test(empty_list_is_no_atom, Pieces == ["2 j", "[[],{\"a\":\"[]\"}]"]) :-
    columns(1, [row([]), row('[]')], Pieces).
test(integer_beyond_64_bits, forall(member(N-L, [ 0x7fffffffffffffff-n, 0x8000000000000000-j,
                                                  -0x8000000000000000-n,
                                                  -0x8000000000000001-j ]))) :-
    columns(1, [row(N), row(1)], [Header, _]),
    atom_string(L, Letter),
    string_concat("2 ", Letter, Header).
test(wide_rows, Header == "2 nnnnnn") :-
    columns(6, [row(1, 2, 3, 4, 5, 6), row(1, 2, 3, 4, 5, 6)], [Header|Pieces]),
    Pieces == ["1,1", "2,2", "3,3", "4,4", "5,5", "6,6"].
test(variable_has_one_name_in_its_row, Pieces == ["1 jj", "[{\"v\":\"X0\"}]", Second]) :-
    columns(2, [row(X, f(_, X))], Pieces),
    Second = "[{\"f\":\"f\",\"t\":[{\"v\":\"X1\"},{\"v\":\"X0\"}]}]".
test(constraint_is_left_out, Piece == "[{\"v\":\"X0\"}]") :-
    freeze(X, true),
    columns(1, [row(X)], [_, Piece]).
test(cyclic_term_is_refused, error(domain_error(acyclic_term, _))) :-
    X = f(X),
    columns(1, [row(X)], _).

:- end_tests(columns).

:- begin_tests(float_bytes).

floats([0.0, -0.0, 1.0, -2.5, 0.1, 5.0e-324, 2.2250738585072014e-308, 1.7976931348623157e308]).

% The nine bytes of each float, without what stands before them.
tail(Floats, Count, Tail) :-
    floats_bytes(Floats, Bytes),
    length(Floats, Count),
    Length is 9*Count,
    sub_string(Bytes, _, Length, 0, Tail).

test(there_and_back, Same == Floats) :-
    floats(Floats),
    tail(Floats, Count, Bytes),
    bytes_floats(Count, Bytes, Same).
test(by_arithmetic_the_same, Same == Floats) :-
    floats(Floats),
    tail(Floats, _, Bytes),
    string_codes(Bytes, Codes),
    facetlog_float_bytes:worked_out(Codes, Same).

:- end_tests(float_bytes).
