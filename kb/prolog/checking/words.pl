:- module(facetlog_words, [ fact_word/1,          % +Goal
                            search_word/1,        % +Indicator
                            test_form/2,          % +Test, -Form
                            known_word/2,         % ?Kind, ?Indicator
                            vocabulary_tolerance/1, % ?Name
                            signature/2,          % +Indicator, -Signature
                            term_signature/3,     % +Kind, +Indicator, -Signature
                            question_words/1      % -Words
                          ]).

/** <module> The words of facts, rules and questions, with their arguments and meaning */

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(library(yall)).
:- use_module(facetlog_kb(schema)).
:- use_module(facetlog_kb(white_list)).
:- use_module(facetlog(vocabulary)).
:- use_module(facetlog(measures)).

%!  fact_word(+Goal) is semidet.
%
%   Goal is a fact of the schema.

fact_word(Goal) :-
    callable(Goal),
    functor(Goal, Name, Arity),
    fact_schema(Name/Arity, _),
    !.

%!  search_word(+Indicator) is semidet.
%
%   The vocabulary exports it. None of these words calls its arguments.

search_word(Indicator) :-
    module_property(vocabulary, exports(Words)),
    memberchk(Indicator, Words).

%!  test_form(+Test, -Form) is semidet.
%
%   Form says what the arguments of a connective or comparison are: test, tests, comparison, measure,
%   weight, share, count, groups, model, value.

test_form(near(_, _, _), near(measure, measure, measure)).
test_form(at_least(_, _), at_least(measure, measure)).
test_form(at_most(_, _), at_most(measure, measure)).
test_form(between(_, _, _), between(measure, measure, measure)).
test_form(all(_), all(tests)).
test_form(any(_), any(tests)).
test_form(each(_, _, _), each(value, value, test)).
test_form(some(_, _, _), some(value, value, test)).
test_form(each_pair(_, _, _, _), each_pair(value, value, value, test)).
test_form(not(_), not(test)).
test_form(if_known(_), if_known(test)).
test_form(expect(_, _), expect(weight, test)).
test_form(implies(_, _), implies(test, test)).
test_form(fading(_, _), fading(comparison, measure)).
test_form(soft(_, _), soft(comparison, share)).
test_form(at_least_of(_, _, _, _), at_least_of(count, value, groups, test)).
test_form(at_least_in(_, _, _, _, _), at_least_in(count, test, value, groups, test)).
test_form(at_most_of(_, _, _, _), at_most_of(count, value, groups, test)).
test_form(is_a(_, _), is_a(value, model)).

%!  vocabulary_tolerance(?Name) is nondet.

vocabulary_tolerance(Name) :-
    clause(vocabulary:tolerance(Name, _), true).

                 /*******************************
                 *          DESCRIPTION         *
                 *******************************/

%   described(Head, Kind, Meaning): meanings of words that neither the vocabulary of models
%   (grammar/vocabulary.py) nor the schema of facts has.
described(thing('Thing'), search, "a connected group of faces, judged as one object").
described(face_of('Thing', 'Face'), search, "a measured face of the thing").
described(loose_edge_of('Thing', 'Edge'), search,
          "a measured edge of the thing that bounds no face").
described(element_of('Thing', 'X'), search, "a measured face or loose edge of the thing").
described(edge_of('Thing', 'Edge'), search, "a side of a measured face of the thing, or loose").
described(vertex_of('Thing', 'Vertex'), search, "a corner of a measured face of the thing").
described(piece_in('Thing', 'Piece'), search, "a solid part of the thing").
described(largest_pieces('Thing', 'Pieces'), search, "the pieces, the largest first").
described(nearest_pieces('Thing', 'Pieces', 'Fitting', 'Nearest'), search,
          "the pieces that may pass all tests; of a thing whose pieces are all known those that may pass most first").
described(piece_choice('Pieces', 'Count', 'Others', 'Piece'), search,
          "one of the first Count pieces that is not among Others, or unseen").
described(opening_through('Thing', 'Opening'), search, "an opening of the thing").
described(largest_openings('Thing', 'Openings'), search, "the openings, the largest first").
described(hollow_in('Thing', 'Hollow'), search, "a hollow of the thing").
described(largest_hollows('Thing', 'Hollows'), search, "the hollows, the largest first").
described(part_in('Thing', 'Model', 'Role', 'Part'), search,
          "the face or piece that plays the part of the model in the thing, or unseen").
described(shared_edge('A', 'B', 'Edge'), search, "the measured faces A and B share the edge").
described(standing_below('Face', 'Support'), search,
          "an upright face or loose edge that supports the face from the ground").
described(undersides('Face', 'Faces'), search,
          "the face, and the lower sides of the board of which it is the upper side").
described(separate('Supports', 'Groups'), search,
          "groups of faces and edges that adjoin one another").
described(line_label('View', 'Edge', 'Label'), search,
          "the label of the edge in the line drawing of the view: convex, concave or occluding").
described(impossible_drawing('View', 'Junction'), search,
          "no solid with flat faces has the drawing of the view; labelling failed at the junction").
described(largest_faces('Thing', 'Faces'), search, "the measured faces, the largest first").
described(longest_first('Measures', 'Sorted'), search, "the measures, sorted by falling value").
described(as_far_as_seen('Thing', 'Steps', 'Parts'), search,
          "for each step(X, Count, Test) one of the largest faces that may pass, or unseen").
described(holds('Test'), search, "the test is known to hold").
described(possible('Test'), search, "the test holds or is unknown").
described(measure('Measure', 'Value', 'Sd', 'Kind'), search,
          "value and deviation of a measure; deg, ratio, count, length or area").
described(relation('Relation', 'Truth'), search, "true, false or unknown").
described(in('Scene', 'Goal'), question,
          "the goal in a scene; in each scene if Scene is unbound").
described(is_a('Thing', 'Model'), question, "the model holds for the thing").
described(verdict('Thing', 'Model', 'State', 'Degree'), question,
          "the verdict of the model on the thing: holds, fails or unknown, and its degree").
described(plays('Face', 'Role', 'Thing', 'Model'), question,
          "the face plays that part of the thing").
described(assignment('Model', 'Thing', 'Parts'), question,
          "the model holds for the thing with these faces as its parts").
described(fact('Fact'), search, "a fact of the scene").
described(near('Measure', 'Target', 'Tolerance'), test, "the measure is within the tolerance").
described(at_least('Measure', 'Limit'), test, "the measure is not below the limit").
described(at_most('Measure', 'Limit'), test, "the measure is not above the limit").
described(between('Measure', 'Low', 'High'), test, "the measure is in that range").
described(all('Tests'), test, "every test holds").
described(any('Tests'), test, "one of the tests holds").
described(each('X', 'List', 'Test'), test, "the test holds of every X in the list").
described(some('X', 'List', 'Test'), test, "the test holds of one X in the list").
described(each_pair('X', 'Y', 'List', 'Test'), test, "the test holds of every two of the list").
described(not('Test'), test, "the test does not hold").
described(if_known('Test'), test, "the test holds, or is not known").
described(expect('Weight', 'Test'), test, "always; if the test does not hold, the degree falls").
described(implies('Where', 'Test'), test, "where the first test holds, the second does").
described(fading('Comparison', 'Width'), test,
          "the comparison, its edges falling off to nothing over the width").
described(soft('Comparison', 'Share'), test,
          "the comparison; its degree falls about each limit, over that share of it to either side").
described(at_least_of('Count', 'X', 'Groups', 'Test'), test,
          "the test holds of one X in each of so many groups, or more").
described(at_least_in('Count', 'Closed', 'X', 'Groups', 'Test'), test,
          "the same; too few fail if the test Closed holds, which says that there are no more").
described(at_most_of('Count', 'X', 'Groups', 'Test'), test,
          "the test holds of one X in no more than so many groups").
described(is_a('Thing', 'Model'), test, "what the model says of the thing").
described(tolerance('Name'), measure, "a number with a name").
described(thing_length('Thing'), measure, "longest side of the thing").
described(thing_width('Thing'), measure, "middle side of the thing").
described(thing_height('Thing'), measure, "height of the thing's highest point").
described(explained('Thing'), measure, "share of the thing's volume that its pieces fill").
described(metres('Number'), measure, "a length, if the scale is known").
described(count('List'), measure, "how many elements the list has").
described(shared_height('X', 'Y'), measure,
          "share of the lower one's height that both take, where X is not beside Y").
described(sunk_share('X', 'Y'), measure,
          "share of the smaller one that is sunk into the other, where X is not beside Y").
described(over_share('X', 'Y'), measure,
          "share of its rest that is over or under the other, where X is not beside Y").
described(smallest_gap('Things'), measure, "least distance between two of the things").
described(largest_gap('Things'), measure, "greatest distance between two of the things").
described(smallest_spacing('Pieces'), measure,
          "seen from above, least distance of neighbours in the row that the pieces stand in").
described(largest_spacing('Pieces'), measure, "greatest distance of neighbours in that row").
described(order('Measures'), measure,
          "share of the steps along the row of their pieces that rise, or that fall, if these are more").
described(lowest('Measures'), measure, "the least of the measures").
described(highest('Measures'), measure, "the greatest of the measures").
described(sum('Measures'), measure, "the sum of the measures").
described(mean('Measures'), measure, "the mean of the measures").
described(smallest_step('Measures'), measure,
          "the least difference of neighbours among the measures in their order").
described(largest_step('Measures'), measure,
          "the greatest difference of neighbours among the measures in their order").
described(openings_known('Thing'), relation, "no unseen space has room for another opening").
described(hollows_known('Thing'), relation, "it is known from all sides: it has no other hollows").
described(pieces_known('Thing'), relation, "its pieces fill all of its volume: it has no others").
described(whole('Thing'), relation, "the thing's surface is known from all sides").
described(scanned('Thing'), relation,
          "the thing's surface is known from some sides, and there all of it that was in sight").

%!  known_word(?Kind, ?Indicator) is nondet.
%
%   Kind is fact, search, question, test, measure, relation or prolog.

known_word(fact, Indicator) :-
    fact_schema(Indicator, _).
known_word(search, Indicator) :-
    (   module_property(vocabulary, exports(Words)),
        member(Indicator, Words),
        described_word(search, Indicator)
    ;   Indicator = fact/1
    ).
known_word(question, Indicator) :-
    described_word(question, Indicator).
known_word(test, Indicator) :-
    described_word(test, Indicator).
known_word(measure, Indicator) :-
    findall(Name/Arity, ( known_measure(Measure), functor(Measure, Name, Arity) ), Measures),
    sort([tolerance/1|Measures], Words),
    member(Indicator, Words).
known_word(relation, Name/Arity) :-
    ( known_relation(Word) ; derived_word(Word) ),
    functor(Word, Name, Arity).
known_word(prolog, Name/Arity) :-
    allowed(Head, _),
    functor(Head, Name, Arity).

described_word(Kind, Name/Arity) :-
    described(Head, Kind, _),
    functor(Head, Name, Arity).

described_signature(Kind, Name/Arity, Signature) :-
    functor(Head, Name, Arity),
    described(Head, Kind, _),
    !,
    written(Head, Signature).

%!  signature(+Indicator, -Signature) is semidet.
%
%   Signature is the word with the names of its arguments, as a goal.

signature(Name/Arity, Signature) :-
    fact_arguments(Name/Arity, Arguments),
    !,
    pairs_of(Arguments, Names),
    Head =.. [Name|Names],
    written(Head, Signature).
signature(Name/Arity, Signature) :-
    (   member(Kind, [search, question]),
        described_signature(Kind, Name/Arity, Signature0)
    ->  Signature = Signature0
    ;   functor(Head, Name, Arity),
        allowed(Head, _)
    ->  plain_head(Head, Plain),
        written(Plain, Signature)
    ).

pairs_of([], []).
pairs_of([Name-_|Pairs], [Name|Names]) :-
    pairs_of(Pairs, Names).

signature_of(Kind, Indicator, Signature) :-
    (   memberchk(Kind, [measure, relation, test])
    ->  term_signature(Kind, Indicator, Signature)
    ;   signature(Indicator, Signature)
    ).

%!  term_signature(+Kind, +Indicator, -Signature) is det.
%
%   The same of a measure, relation or test; a measure has the first arguments of the fact of its name.

term_signature(Kind, Indicator, Signature) :-
    described_signature(Kind, Indicator, Signature),
    !.
term_signature(_, Name/Arity, Signature) :-
    length(Names, Arity),
    (   fact_arguments(Name/_, Arguments),
        pairs_of(Arguments, All),
        append(Names, _, All)
    ->  true
    ;   foldl([Letter, Code, Next]>>( char_code(Letter, Code), Next is Code + 1 ),
              Names, 0'A, _)
    ),
    Head =.. [Name|Names],
    written(Head, Signature).

%   Without what the white list says of the arguments' use.
plain_head(Head, Plain) :-
    Head =.. [Name|Arguments],
    maplist(plain_argument, Arguments, Names),
    Plain =.. [Name|Names].

plain_argument(closure(_, Name), Name) :- !.
plain_argument(Argument, Name) :-
    compound(Argument),
    !,
    arg(1, Argument, Name).
plain_argument(Name, Name).

%   Names stand unquoted, operators between their arguments.
written(Head, Signature) :-
    Options = [quoted(false), spacing(next_argument), portray(false)],
    format(string(Signature), "~W", [Head, Options]).

%!  question_words(-Words) is det.
%
%   Words are word(Indicator, Kind, Signature, Meaning), for help and completion.

question_words(Words) :-
    findall(word(Indicator, Kind, Signature, Meaning),
            ( known_word(Kind, Indicator),
              signature_of(Kind, Indicator, Signature),
              meaning(Kind, Indicator, Meaning) ),
            Words).

meaning(fact, Indicator, Meaning) :-
    !,
    fact_schema(Indicator, Meaning).
meaning(prolog, Name/Arity, Meaning) :-
    !,
    functor(Head, Name, Arity),
    allowed(Head, Meaning).
meaning(Kind, Name/Arity, Meaning) :-
    (   functor(Head, Name, Arity),
        described(Head, Kind, Meaning0)
    ->  Meaning = Meaning0
    ;   memberchk(Kind, [measure, relation]),
        word_of_models(Name, Word),
        word_meaning(Word, Meaning0)
    ->  Meaning = Meaning0
    ;   fact_schema(Name/_, Meaning0)
    ->  Meaning = Meaning0
    ;   Meaning = ""
    ).

%   Pieces and openings have other names here than in models.
word_of_models(Name, Word) :-
    (   member(Prefix, [piece_, opening_]),
        atom_concat(Prefix, Word0, Name)
    ->  Word = Word0
    ;   Word = Name
    ).
