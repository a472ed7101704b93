% Supports that are one leg, against the plain definition: whatever is joined pair by pair.
:- use_module(library(plunit)).
:- use_module(library(random)).
:- use_module(library(lists)).
:- use_module(facetlog_kb(scene)).
:- use_module(facetlog(grouping)).

% A thing of length 10, so that feet within 1.5 are one leg's; each support is a short edge.
standing(Points, Supports, Facts) :-
    findall(s(S)-P, nth1(S, Points, P), Numbered),
    findall(Name-P, ( member(s(S)-P, Numbered), atom_concat(e, S, Name) ), Named),
    findall(Name, member(Name-_, Named), Supports),
    findall(Fact,
            ( member(Name-[X, Y], Named),
              atom_concat(Name, a, V1),
              atom_concat(Name, b, V2),
              Z is 1.0,
              member(Fact, [ part_of(Name, t1), edge(Name, V1, V2), point(V1, X, Y, 0.0),
                             point(V2, X, Y, Z) ]) ),
            Facts).

groups(Points, Groups) :-
    standing(Points, Supports, Facts),
    gensym(test_scene, Scene),
    setup_call_cleanup(
        new_scene(Scene),
        ( forall(member(Fact, [thing(t1), up(0.0, 0.0, 1.0), thing_size(t1, 10.0, 5.0, 1.0)|Facts]),
                 add_fact(Scene, Fact)),
          in_scene(Scene, separate(Supports, Groups)) ),
        destroy_scene(Scene)).

plain_groups(Points, Groups) :-
    findall(Name-P, ( nth1(S, Points, P), atom_concat(e, S, Name) ), Named),
    merge_all(Named, [], Groups0),
    findall(Names, ( member(G, Groups0), findall(N, member(N-_, G), Ns), sort(Ns, Names) ), Groups1),
    sort(Groups1, Groups).

merge_all([], Groups, Groups).
merge_all([Support|Supports], Groups0, Groups) :-
    partition([Group]>>near_group(Support, Group), Groups0, Near, Apart),
    append(Near, Members),
    merge_all(Supports, [[Support|Members]|Apart], Groups).

near_group(_-[X, Y], Group) :-
    member(_-[A, B], Group),
    sqrt((A - X)**2 + (B - Y)**2) =< 1.5,
    !.

random_points(Seed, Points) :-
    set_random(seed(Seed)),
    findall([X, Y], ( between(1, 14, _), random(A), random(B), X is 10*A, Y is 5*B ), Points).

:- begin_tests(grouping).

test(nothing_is_no_group, Groups == []) :-
    groups([], Groups).
test(four_legs, N == 4) :-
    groups([[0.0, 0.0], [9.0, 0.0], [0.0, 4.0], [9.0, 4.0]], Groups),
    length(Groups, N).
test(a_row_of_near_feet_is_one, N == 1) :-
    findall([X, 0.0], ( between(0, 8, I), X is 1.4*I ), Points),
    groups(Points, Groups),
    length(Groups, N).
test(random_feet_group_as_pair_by_pair, [forall(between(1, 60, Seed)), Groups == Plain]) :-
    random_points(Seed, Points),
    groups(Points, Groups),
    plain_groups(Points, Plain).

:- end_tests(grouping).
